//! `serve`: a page in the browser for those who use neither a terminal nor Python. It takes a scan, prepares it,
//! presses it with the options of `contact`, and shows the result. The server listens on this machine alone.

mod answer;
mod form;
mod guard;
mod map;
mod repeat;
mod routes;
mod runs;
mod scans;

use std::fmt;
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use clap::Args as ClapArgs;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_problem::key;
use oxhttp::Server;
use serde::Serialize;

use guard::Guard;
use routes::Desk;

/// Flags of `serve`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd serve --open
  gfmd serve --port 8080 --folder results --upload-limit 64")]
pub struct Args {
    /// Port on 127.0.0.1; 0 picks a free one
    #[arg(long, default_value_t = 0, value_name = "PORT", help_heading = "Server")]
    port: u16,
    /// Open the page in the browser
    #[arg(long, help_heading = "Server")]
    open: bool,
    /// Folder for scans and results, created if missing
    #[arg(long, default_value = "gfmd-results", value_name = "FOLDER", help_heading = "Server")]
    folder: PathBuf,
    /// Largest upload size, MiB
    #[arg(long, default_value_t = 256, value_name = "MIB", help_heading = "Server")]
    upload_limit: u32,
}

/// Address of the page, printed when the server starts.
#[derive(Clone, Debug, Serialize)]
pub struct Started {
    /// Address, with the token.
    pub address: String,
    /// Folder of scans and results.
    pub folder: PathBuf,
}

impl fmt::Display for Started {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "page:    {}", self.address)?;
        writeln!(f, "results: {}", self.folder.display())?;
        writeln!(f, "Ctrl-C ends the server.")
    }
}

/// Number of connections at a time. A browser keeps six.
const MOST_CONNECTIONS: usize = 64;

/// Time in which a silent connection is closed.
const SILENCE: Duration = Duration::from_secs(60);

/// Time between two checks for Ctrl-C.
const PAUSE: Duration = Duration::from_millis(50);

/// Number of attempts to take a free port, which another program may take first.
const ATTEMPTS: usize = 8;

/// Runs the server until the user asks to stop; `show` prints its address at the start. Running contacts then end, with
/// the finished loads kept.
///
/// # Errors
/// Returns an error if the folder cannot be made, or the port is in use.
pub fn run(args: &Args, session: &Session, show: impl FnOnce(&Started) -> Result<(), Failure>) -> Result<(), Failure> {
    if session.ranks().is_some() {
        return Err(Failure::refused("serve runs in one process; it must not be started by mpirun"));
    }
    if args.upload_limit == 0 {
        return Err(Failure::value(key("upload_limit"), 0, "at least 1"));
    }
    let made = std::fs::create_dir_all(&args.folder).and_then(|()| std::fs::canonicalize(&args.folder));
    let folder = made.map_err(|error| Failure::input(key("folder"), format!("{}: {error}", args.folder.display())))?;
    if folder.to_str().is_none() {
        return Err(Failure::value(key("folder"), folder.display(), "UTF-8, since results record it"));
    }
    let token = guard::token().map_err(|error| Failure::computation(format!("no random numbers: {error}")))?;
    let desk = Desk::new(folder.clone(), u64::from(args.upload_limit) << 20, rayon::current_num_threads())?;
    let desk = Arc::new(desk);
    let port = listen(args.port, &token, &desk)?;
    let started = Started { address: format!("http://127.0.0.1:{port}/{token}/"), folder };
    show(&started)?;
    if args.open {
        open(&started.address, session);
    }
    while !session.is_interrupted() {
        std::thread::sleep(PAUSE);
    }
    desk.runs.end();
    Ok(())
}

/// Starts the server and returns its port.
fn listen(asked: u16, token: &str, desk: &Arc<Desk>) -> Result<u16, Failure> {
    let refused = |error: io::Error| Failure::input(key("port"), format!("{asked}: {error}"));
    for attempt in 1.. {
        let port = match asked {
            // The server takes no open socket, so that the port is found and freed first.
            0 => TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
                .and_then(|found| found.local_addr())
                .map_err(refused)?
                .port(),
            port => port,
        };
        let (guard, desk) = (Guard::new(token, port), Arc::clone(desk));
        let server = Server::new(move |request| routes::answer(request, &guard, &desk));
        let server = server.bind((Ipv4Addr::LOCALHOST, port)).with_global_timeout(SILENCE);
        match server.with_max_concurrent_connections(MOST_CONNECTIONS).spawn() {
            Ok(_) => return Ok(port),
            Err(error) if asked != 0 || attempt == ATTEMPTS => return Err(refused(error)),
            Err(_) => {}
        }
    }
    unreachable!("an attempt returns")
}

/// Opens the page in the browser of the user; warns if no program does.
fn open(address: &str, session: &Session) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let started =
        Command::new(program).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if let Err(error) = started {
        session.warn("browser", format!("cannot start the browser by {program}: {error}; open the address yourself"));
    }
}
