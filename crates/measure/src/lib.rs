//! Numbers from contact fields: contact area, perimeter correction, kappa, pressure statistics, comparison theories.
