//! Functions of an MPI library; the only unsafe code of the crate.
//!
//! The signatures follow the standard (MPI 3.1, sections 5.5, 5.8, 5.12.2, 3.7.3, 8.7), with the handles of
//! [`BinaryInterface`].
#![expect(unsafe_code, reason = "a C library has no other interface")]

use std::ffi::{c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::ptr::null;

use gfmd_vector::Messages;
use libloading::Library;

use crate::kind::{BinaryInterface, MPICH, OPEN_MPI_SERIALIZED, STANDARD};

/// MPI handle: an `int` in MPICH, an address elsewhere, stored as a number of its size.
pub(crate) trait Handle: Copy + Send + Sync + 'static {
    const NONE: Self;
    fn of(number: usize) -> Self;
}

impl Handle for c_int {
    const NONE: Self = 0;

    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "the bits of an int")]
    fn of(number: usize) -> Self {
        number as Self
    }
}

impl Handle for usize {
    const NONE: Self = 0;

    fn of(number: usize) -> Self {
        number
    }
}

/// Functions of a library, and two communicators of all processes: one for messages, one for the meeting at the end.
pub(crate) struct Functions<H> {
    word: H,
    communicator: H,
    last: H,
    all_gather: unsafe extern "C" fn(*const u64, c_int, H, *mut u64, *const c_int, *const c_int, H, H) -> c_int,
    broadcast: unsafe extern "C" fn(*mut u64, c_int, H, c_int, H) -> c_int,
    all_to_all: unsafe extern "C" fn(
        *const u64,
        *const c_int,
        *const c_int,
        H,
        *mut u64,
        *const c_int,
        *const c_int,
        H,
        H,
        *mut H,
    ) -> c_int,
    barrier: unsafe extern "C" fn(H, *mut H) -> c_int,
    test: unsafe extern "C" fn(*mut H, *mut c_int, *mut c_void) -> c_int,
    wait: unsafe extern "C" fn(*mut H, *mut c_void) -> c_int,
    abort: unsafe extern "C" fn(H, c_int) -> c_int,
    finalize: unsafe extern "C" fn() -> c_int,
}

/// Size of the buffer for the version text of a library, in bytes. A status, below 100 bytes, gets an eighth of it.
const TEXT: usize = 8192;

/// Initialised library, by the type of its handles.
pub(crate) enum Begun {
    Numbers(Functions<c_int>),
    Addresses(Functions<usize>),
}

/// Version text of a library, rank of this process and number of processes.
pub(crate) struct About {
    pub(crate) version: String,
    pub(crate) rank: usize,
    pub(crate) size: usize,
}

/// Loads the library `file` and initialises MPI. If its version does not satisfy `fits`, returns only the version.
pub(crate) fn begin(
    file: &str,
    fits: impl Fn(&str) -> bool,
) -> Result<Result<(Begun, About), String>, libloading::Error> {
    let library = open(file)?;
    let version = version(&library)?;
    if !fits(&version) {
        return Ok(Err(version));
    }
    // SAFETY: the symbol is looked up, not used.
    let has_open_mpi = unsafe { library.get::<*const c_void>(b"ompi_mpi_comm_world\0") }.is_ok();
    let (begun, rank, size) = match BinaryInterface::of(file, has_open_mpi) {
        BinaryInterface::OpenMpi => {
            let address = |name: &[u8]| {
                // SAFETY: the address of an object is taken, not read.
                unsafe { library.get::<*const c_void>(name) }.map(|symbol| *symbol as usize)
            };
            let (world, word) = (address(b"ompi_mpi_comm_world\0")?, address(b"ompi_mpi_uint64_t\0")?);
            let (functions, rank, size) = Functions::begin(&library, world, word, OPEN_MPI_SERIALIZED)?;
            (Begun::Addresses(functions), rank, size)
        }
        BinaryInterface::Mpich => {
            let (world, word) = (Handle::of(MPICH.world), Handle::of(MPICH.word));
            let (functions, rank, size) = Functions::begin(&library, world, word, MPICH.serialized)?;
            (Begun::Numbers(functions), rank, size)
        }
        BinaryInterface::Standard => {
            let (world, word) = (STANDARD.world, STANDARD.word);
            let (functions, rank, size) = Functions::begin(&library, world, word, STANDARD.serialized)?;
            (Begun::Addresses(functions), rank, size)
        }
    };
    Ok(Ok((begun, About { version, rank, size })))
}

/// Returns the first line of the version text, which is available before the initialisation.
fn version(library: &Library) -> Result<String, libloading::Error> {
    type Version = unsafe extern "C" fn(*mut c_char, *mut c_int) -> c_int;
    // SAFETY: the type is the one in the standard.
    let version = unsafe { library.get::<Version>(b"MPI_Get_library_version\0") }?;
    let (mut text, mut length) = (vec![0_u8; TEXT], 0);
    // SAFETY: the buffer has the greatest length that any library states, and `length` outlives the call.
    unsafe { version(text.as_mut_ptr().cast(), &raw mut length) };
    text.truncate(usize::try_from(length).unwrap_or(0));
    Ok(String::from_utf8_lossy(&text).lines().next().unwrap_or_default().trim_matches('\0').to_owned())
}

/// Opens a library that is never closed: its threads and handlers would be left without code.
fn open(file: &str) -> Result<ManuallyDrop<Library>, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{self, RTLD_GLOBAL, RTLD_NOW};
        // SAFETY: the initialisers of an MPI library have no conditions. Its modules need its symbols to be global
        // (Open MPI).
        let library = unsafe { unix::Library::open(Some(file), RTLD_NOW | RTLD_GLOBAL) }?;
        Ok(ManuallyDrop::new(library.into()))
    }
    #[cfg(not(unix))]
    // SAFETY: the initialisers of an MPI library have no conditions.
    Ok(ManuallyDrop::new(unsafe { Library::new(file) }?))
}

impl<H: Handle> Functions<H> {
    fn begin(
        library: &Library,
        world: H,
        word: H,
        serialized: c_int,
    ) -> Result<(Self, usize, usize), libloading::Error> {
        /// Looks up a function by its name.
        macro_rules! function {
            ($name:literal, $type:ty) => {
                // SAFETY: the type is the one in the standard, with the handles of this library, which is never closed.
                *unsafe { library.get::<$type>(concat!($name, "\0").as_bytes()) }?
            };
        }
        let init =
            function!("MPI_Init_thread", unsafe extern "C" fn(*const c_int, *const c_void, c_int, *mut c_int) -> c_int);
        let rank = function!("MPI_Comm_rank", unsafe extern "C" fn(H, *mut c_int) -> c_int);
        let size = function!("MPI_Comm_size", unsafe extern "C" fn(H, *mut c_int) -> c_int);
        let duplicate = function!("MPI_Comm_dup", unsafe extern "C" fn(H, *mut H) -> c_int);
        let mut functions = Self {
            word,
            communicator: world,
            last: world,
            all_gather: function!("MPI_Allgatherv", _),
            broadcast: function!("MPI_Bcast", _),
            all_to_all: function!("MPI_Ialltoallv", _),
            barrier: function!("MPI_Ibarrier", _),
            test: function!("MPI_Test", _),
            wait: function!("MPI_Wait", _),
            abort: function!("MPI_Abort", _),
            finalize: function!("MPI_Finalize", _),
        };
        let (mut provided, mut own, mut all) = (0, 0, 0);
        // SAFETY: called once, by `start`. Every pointer is to a living variable of the type in the standard, and all
        // processes duplicate the two communicators in the same order.
        unsafe {
            init(null(), null(), serialized, &raw mut provided);
            rank(world, &raw mut own);
            size(world, &raw mut all);
            duplicate(world, &raw mut functions.communicator);
            duplicate(world, &raw mut functions.last);
        }
        Ok((functions, own.unsigned_abs() as usize, all.unsigned_abs() as usize))
    }

    /// Gathers `own` from all ranks into `all`; rank r sends `lengths[r]` words. The sum must be below 2³¹.
    pub(crate) fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]) {
        let (counts, places) = counts(lengths);
        let count = int(own.len());
        assert_eq!(all.len(), lengths.iter().sum::<usize>(), "the words of all ranks");
        // SAFETY: `own` has `count` words, `all` has room for the words of all ranks at their places, and both live
        // until the call returns.
        unsafe {
            (self.all_gather)(
                own.as_ptr(),
                count,
                self.word,
                all.as_mut_ptr(),
                counts.as_ptr(),
                places.as_ptr(),
                self.word,
                self.communicator,
            );
        }
    }

    /// Broadcasts `words` from the rank `from`.
    pub(crate) fn broadcast(&self, words: &mut [u64], from: usize) {
        let count = int(words.len());
        // SAFETY: `count` is the length of `words`, which live until the call returns.
        unsafe { (self.broadcast)(words.as_mut_ptr(), count, self.word, int(from), self.communicator) };
    }

    /// Starts an exchange that owns `messages` until it ends.
    pub(crate) fn post(&self, mut messages: Messages) -> Exchange<'_, H> {
        // Open MPI treats equal addresses, as of two empty vectors, as a call in place, which waits for all other
        // processes.
        for words in [&mut messages.out, &mut messages.into] {
            if words.is_empty() {
                words.reserve(1);
            }
        }
        let ((out_counts, out_places), (into_counts, into_places)) =
            (counts(&messages.out_lengths), counts(&messages.into_lengths));
        assert_eq!(messages.out.len(), messages.out_lengths.iter().sum::<usize>(), "every word has a receiver");
        assert_eq!(messages.into.len(), messages.into_lengths.iter().sum::<usize>(), "every word has a sender");
        let numbers = [out_counts, out_places, into_counts, into_places];
        let mut exchange = Exchange { functions: self, messages, numbers, request: H::NONE, over: false };
        let Exchange { messages, numbers, request, .. } = &mut exchange;
        // SAFETY: the vectors have the lengths checked above. They are on the heap and belong to the exchange, which
        // gives them back only after MPI_Wait, waits when it is dropped, and frees nothing if it is forgotten.
        unsafe {
            (self.all_to_all)(
                messages.out.as_ptr(),
                numbers[0].as_ptr(),
                numbers[1].as_ptr(),
                self.word,
                messages.into.as_mut_ptr(),
                numbers[2].as_ptr(),
                numbers[3].as_ptr(),
                self.word,
                self.communicator,
                &raw mut *request,
            );
        }
        exchange
    }

    /// Waits until all processes have arrived or `goes_on` returns false. Returns true if all have arrived.
    pub(crate) fn meet(&self, mut goes_on: impl FnMut() -> bool) -> bool {
        let (mut request, mut done) = (H::NONE, 0);
        let mut status = [0_u64; TEXT / 64];
        // SAFETY: the first call writes the request, which belongs to this function; the status has room for the status
        // of any library, and all ranks meet once. If the meeting is given up, all processes are aborted.
        unsafe { (self.barrier)(self.last, &raw mut request) };
        while done == 0 && goes_on() {
            // SAFETY: as above.
            unsafe { (self.test)(&raw mut request, &raw mut done, status.as_mut_ptr().cast()) };
        }
        done != 0
    }

    /// Aborts all processes with this exit status.
    pub(crate) fn abort(&self, status: u8) {
        // SAFETY: it may be called at any time after the initialisation.
        unsafe { (self.abort)(self.communicator, c_int::from(status)) };
    }

    /// Finalises MPI in this process.
    pub(crate) fn finalize(&self) {
        // SAFETY: called once, by `World::end`, when all have met and no exchange is under way.
        unsafe { (self.finalize)() };
    }
}

/// Exchange in progress.
pub(crate) struct Exchange<'a, H: Handle> {
    functions: &'a Functions<H>,
    messages: Messages,
    /// Counts and displacements of sent and received words, which the library may read until the end.
    numbers: [Vec<c_int>; 4],
    request: H,
    over: bool,
}

impl<H: Handle> Exchange<'_, H> {
    fn finish(&mut self) {
        if !std::mem::replace(&mut self.over, true) {
            let mut status = [0_u64; TEXT / 64];
            // SAFETY: `post` has written the request, which is waited for once; the status has room for any library.
            unsafe { (self.functions.wait)(&raw mut self.request, status.as_mut_ptr().cast()) };
        }
    }
}

impl<H: Handle> gfmd_vector::Pending for Exchange<'_, H> {
    fn wait(mut self: Box<Self>) -> Messages {
        self.finish();
        self.numbers.iter_mut().for_each(Vec::clear);
        std::mem::take(&mut self.messages)
    }
}

impl<H: Handle> Drop for Exchange<'_, H> {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Returns counts and displacements of words, as integers of the library.
fn counts(lengths: &[usize]) -> (Vec<c_int>, Vec<c_int>) {
    let places = lengths.iter().scan(0, |place, length| {
        let own = *place;
        *place += length;
        Some(int(own))
    });
    let places = places.collect();
    (lengths.iter().map(|length| int(*length)).collect(), places)
}

/// Converts a count to an integer of the library.
fn int(count: usize) -> c_int {
    c_int::try_from(count).expect("messages are below 2³¹ words: the rounds of a transform see to it")
}
