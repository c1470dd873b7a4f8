"""Contact mechanics of rough surfaces by Green's function molecular dynamics.

Arrays are [x, y], first index x. Surface heights have their peaks towards the body. Pressure is normal traction on the
body, compression positive, never a force. Any consistent set of units is valid. Attributes have the names of the keys
in docs/interface.md.

Example:
    >>> import gfmd
    >>> s = gfmd.self_affine(n=256, hurst=0.8, rms_gradient=0.1, seed=1)
    >>> c = gfmd.contact(s, gfmd.Body(young=1.0, poisson=0.3), p_star=0.05)
    >>> round(c.area_fraction, 3)
    0.114
"""

from ._body import Body, Law, Material, law, material
from ._below import FieldsBelow, Green, Punch, green, interior, punch
from ._cite import cite
from ._contact import Adhesion, Contact, Contacts, Flow, Gradient
from ._errors import Error, InputError, Interrupted, NotConverged
from ._estimate import Estimate, estimate
from ._fe_table import fe_table
from ._files import load
from ._gfmd import VERSION as __version__
from ._kappa import KappaSweep, kappa_sweep
from ._load import Residual
from ._many import many
from ._parts import Wear
from ._path import Path, PathGradient, friction, path, wear
from ._progress import progress
from ._prony import PronyFit, prony
from ._record import Record
from ._result import Result
from ._shape import cone, cylinder, ellipsoid, flat_punch, paraboloid, sphere, wave, wedge
from ._slide import Slide, slide
from ._solve import contact, contacts
from ._study import Study, study
from ._surface import Statistics, Surface, profile, read, read_heights, self_affine

__all__ = [
    "Adhesion",
    "Body",
    "Contact",
    "Contacts",
    "Error",
    "Estimate",
    "FieldsBelow",
    "Flow",
    "Gradient",
    "Green",
    "InputError",
    "Interrupted",
    "KappaSweep",
    "Law",
    "Material",
    "NotConverged",
    "Path",
    "PathGradient",
    "PronyFit",
    "Punch",
    "Record",
    "Residual",
    "Result",
    "Slide",
    "Statistics",
    "Study",
    "Surface",
    "Wear",
    "__version__",
    "cite",
    "cone",
    "contact",
    "contacts",
    "cylinder",
    "ellipsoid",
    "estimate",
    "fe_table",
    "flat_punch",
    "friction",
    "green",
    "interior",
    "kappa_sweep",
    "law",
    "load",
    "many",
    "material",
    "paraboloid",
    "path",
    "profile",
    "progress",
    "prony",
    "punch",
    "read",
    "read_heights",
    "self_affine",
    "slide",
    "sphere",
    "study",
    "wave",
    "wear",
    "wedge",
]
