//! The binary interfaces of MPI libraries, by what their headers state.

/// The constants of a library in which handles are numbers.
#[derive(Clone, Copy)]
pub(crate) struct Constants {
    pub(crate) world: usize,
    /// An unsigned number of 64 bits.
    pub(crate) word: usize,
    pub(crate) serialized: i32,
}

/// A binary interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Handles are addresses of objects of the library.
    OpenMpi,
    /// Handles are numbers of the size of an `int`: MPICH and its relatives.
    Mpich,
    /// Handles are addresses, of which the predefined ones are small numbers: the standard of MPI 5.
    Standard,
}

/// `mpi.h` of MPICH 5.0.2; the same since MPICH 3.1 (the common interface of its relatives).
pub(crate) const MPICH: Constants = Constants { world: 0x4400_0000, word: 0x4c00_083e, serialized: 2 };

/// `mpi_abi.h` of MPI 5.0.
pub(crate) const STANDARD: Constants = Constants { world: 0x101, word: 0x259, serialized: 2048 };

/// `mpi.h` of Open MPI, whose handles are symbols.
pub(crate) const OPEN_MPI_SERIALIZED: i32 = 2;

impl Kind {
    /// The interface of a library with this file name, of which it is known whether it has the symbols of Open MPI.
    pub(crate) fn of(file: &str, has_open_mpi: bool) -> Self {
        let name = file.rsplit('/').next().unwrap_or(file);
        match has_open_mpi {
            true => Self::OpenMpi,
            false if name.contains("mpi_abi") => Self::Standard,
            false => Self::Mpich,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interfaces_are_known_by_symbol_and_name() {
        assert_eq!(Kind::of("libmpi.so.40", true), Kind::OpenMpi);
        assert_eq!(Kind::of("/opt/mpi_abi/lib/libmpi.so.12", false), Kind::Mpich);
        assert_eq!(Kind::of("/usr/lib/libmpi_abi.so.1", false), Kind::Standard);
    }
}
