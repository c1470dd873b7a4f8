//! Binary interfaces of MPI libraries, with the constants of their headers.

/// Constants of a library that has numbers as handles.
#[derive(Clone, Copy)]
pub(crate) struct Constants {
    pub(crate) world: usize,
    /// Type of an unsigned integer of 64 bits.
    pub(crate) word: usize,
    pub(crate) serialized: i32,
}

/// A binary interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryInterface {
    /// Handles are addresses of objects of the library.
    OpenMpi,
    /// Handles are numbers of the size of an `int`: MPICH and its relatives.
    Mpich,
    /// Handles are addresses, or small numbers if predefined: the standard of MPI 5.
    Standard,
}

/// `mpi.h` of MPICH 5.0.2; unchanged since MPICH 3.1 (the common interface of its relatives).
pub(crate) const MPICH: Constants = Constants { world: 0x4400_0000, word: 0x4c00_083e, serialized: 2 };

/// `mpi_abi.h` of MPI 5.0.
pub(crate) const STANDARD: Constants = Constants { world: 0x101, word: 0x259, serialized: 2048 };

/// `mpi.h` of Open MPI, in which handles are symbols.
pub(crate) const OPEN_MPI_SERIALIZED: i32 = 2;

impl BinaryInterface {
    /// Returns the interface of a library from its file name; `has_open_mpi` is true if it has the symbols of Open MPI.
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
        assert_eq!(BinaryInterface::of("libmpi.so.40", true), BinaryInterface::OpenMpi);
        assert_eq!(BinaryInterface::of("/opt/mpi_abi/lib/libmpi.so.12", false), BinaryInterface::Mpich);
        assert_eq!(BinaryInterface::of("/usr/lib/libmpi_abi.so.1", false), BinaryInterface::Standard);
    }
}
