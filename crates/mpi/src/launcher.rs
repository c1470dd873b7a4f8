//! Detection of the launcher by the variables that it sets for each process.

/// Launcher that started this process as one of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launcher {
    /// Name of the launcher.
    pub name: &'static str,
    /// Rank of this process.
    pub rank: usize,
    /// Number of processes, more than one.
    pub size: usize,
    /// Number of processes on this machine; 1 if the launcher does not give it.
    pub local: usize,
    /// Files of its libraries, the most likely one first.
    pub(crate) libraries: &'static [&'static str],
}

/// Name, variables with rank, size and number of processes on this machine, and libraries.
type Known = (&'static str, [&'static str; 3], &'static [&'static str]);

const OPEN_MPI: &str = "Open MPI's mpirun";

/// Known launchers. The order matters: mpirun inside a SLURM job is recognised as mpirun.
const LAUNCHERS: [Known; 3] = [
    (
        OPEN_MPI,
        ["OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE"],
        &["libmpi.so.40", "libmpi.so", "libmpi.dylib"],
    ),
    ("MPICH's mpiexec or one like it", ["PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"], &MPICH),
    // Set for a step only: a batch script, which is one process, has the number of tasks of its job.
    ("srun", ["SLURM_PROCID", "SLURM_STEP_NUM_TASKS", "SLURM_NTASKS_PER_NODE"], &MPICH),
];

const MPICH: [&str; 6] =
    ["libmpi.so.12", "libmpi_abi.so.1", "libmpi_abi.so.0", "libmpi.so.40", "libmpi.so", "libmpi.dylib"];

impl Launcher {
    /// Returns the launcher that started this process as one of several.
    pub fn found() -> Option<Self> {
        Self::by(|name| std::env::var(name).ok())
    }

    /// Returns false for a library of another launcher, which may end the process when it is initialised.
    pub(crate) fn starts(&self, version: &str) -> bool {
        self.name != OPEN_MPI || version.starts_with("Open MPI")
    }

    fn by(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        LAUNCHERS.iter().find_map(|(name, variables, libraries)| {
            let [rank, size, local] = variables.map(|name| variable(name)?.parse().ok());
            let (rank, size) = (rank?, size?);
            let local = local.unwrap_or(1).clamp(1, size);
            (size > 1 && rank < size).then_some(Self { name, rank, size, local, libraries })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by(variables: &[(&str, &str)]) -> Option<Launcher> {
        Launcher::by(|name| variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn launchers_are_known_by_their_variables() {
        let found = by(&[("OMPI_COMM_WORLD_RANK", "1"), ("OMPI_COMM_WORLD_SIZE", "4")]).unwrap();
        assert_eq!((found.name, found.rank, found.size, found.local), ("Open MPI's mpirun", 1, 4, 1));
        let both = [("SLURM_PROCID", "0"), ("SLURM_STEP_NUM_TASKS", "8"), ("PMI_RANK", "2"), ("PMI_SIZE", "8")];
        assert_eq!(by(&both).unwrap().rank, 2);
        assert_eq!(by(&[both[2], both[3], ("MPI_LOCALNRANKS", "4")]).unwrap().local, 4);
        assert_eq!(by(&both[..2]).unwrap().name, "srun");
    }

    #[test]
    fn one_process_and_a_batch_script_have_none() {
        assert_eq!(by(&[]), None);
        assert_eq!(by(&[("PMI_RANK", "0"), ("PMI_SIZE", "1")]), None);
        assert_eq!(by(&[("SLURM_PROCID", "0"), ("SLURM_NTASKS", "64")]), None);
        assert_eq!(by(&[("PMI_RANK", "x"), ("PMI_SIZE", "4")]), None);
    }
}
