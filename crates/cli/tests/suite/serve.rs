//! The server of `gfmd serve`, asked as a browser does, and as one must not.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use gfmd_files::Reader;
use serde_json::{Value, json};

use crate::common::{gfmd, numbers};

/// Time after which a run counts as hung.
const PATIENCE: Duration = Duration::from_secs(120);

/// Server in a folder of its own, ended with the test.
struct Served {
    child: Child,
    folder: tempfile::TempDir,
    host: String,
    token: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Answer of the server: status, headers in small letters, body.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", self.head))
    }

    /// Returns the message of a refusal.
    fn error(&self) -> String {
        self.json()["error"].as_str().unwrap_or_default().to_owned()
    }
}

impl Served {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_gfmd"))
            .args(["serve", "--json", "--threads", "1", "--folder", "results", "--upload-limit", "1"])
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let started: Value = serde_json::from_str(&line).unwrap();
        let address = started["address"].as_str().unwrap().strip_prefix("http://").unwrap().to_owned();
        let (host, token) = address.trim_end_matches('/').split_once('/').unwrap();
        Self { child, folder, host: host.to_owned(), token: token.to_owned() }
    }

    fn results(&self) -> PathBuf {
        std::fs::canonicalize(self.folder.path()).unwrap().join("results")
    }

    /// Sends a request as it is written.
    fn send(&self, head: &str, body: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(head.replace('\n', "\r\n").as_bytes()).unwrap();
        // The server may answer before it has read a body that is too large.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer with a head");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap().to_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let body = bytes[end + 4..].to_vec();
        let body = if head.contains("transfer-encoding: chunked") { dechunked(&body) } else { body };
        Answer { status, head, body }
    }

    /// Sends a request of the page, with more `headers`, each with its line end.
    fn ask(&self, method: &str, path: &str, headers: &str, body: &[u8]) -> Answer {
        let Self { host, token, .. } = self;
        let length = if method == "POST" { format!("Content-Length: {}\n", body.len()) } else { String::new() };
        let head = format!("{method} /{token}/{path} HTTP/1.1\nHost: {host}\nConnection: close\n{length}{headers}\n");
        self.send(&head, body)
    }

    fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, "", &[])
    }

    fn post(&self, path: &str, value: &Value) -> Answer {
        let headers =
            format!("Origin: http://{}\nContent-Type: application/json\nSec-Fetch-Site: same-origin\n", self.host);
        self.ask("POST", path, &headers, value.to_string().as_bytes())
    }

    fn upload(&self, name: &str, bytes: &[u8]) -> Answer {
        let headers = format!("Content-Type: application/octet-stream\nX-Name: {name}\n");
        self.ask("POST", "upload", &headers, bytes)
    }

    /// Waits until a run has reached one of these phases, and returns its description.
    fn wait(&self, run: u64, phases: &[&str]) -> Value {
        let began = Instant::now();
        loop {
            let about = self.get(&format!("run/{run}")).json();
            if phases.iter().any(|phase| about["state"]["phase"] == *phase) {
                return about;
            }
            assert!(began.elapsed() < PATIENCE, "{about}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn files(&self) -> Vec<String> {
        let names = std::fs::read_dir(self.results()).unwrap();
        let mut names: Vec<String> = names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn dechunked(mut body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    loop {
        let end = body.windows(2).position(|two| two == b"\r\n").unwrap();
        let length = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap(), 16).unwrap();
        if length == 0 {
            return whole;
        }
        whole.extend_from_slice(&body[end + 2..end + 2 + length]);
        body = &body[end + 4 + length..];
    }
}

/// Points of the scan along a side.
const POINTS: usize = 24;

/// Returns a scan as text, with a missing point.
fn scan() -> Vec<u8> {
    tilted(0.0)
}

/// Returns this scan with a slope along x, length for each point.
fn tilted(slope: f64) -> Vec<u8> {
    let at = |k: usize| std::f64::consts::TAU * k as f64 / POINTS as f64;
    let height = |i, j| {
        1e-8 * ((2.0 * at(i)).sin() + (3.0 * at(j) + 1.0).cos() * at(i).cos() + 0.3 * (5.0 * at(i) + at(j)).sin())
    };
    let value = |i, j| if (i, j) == (3, 4) { "nan".into() } else { format!("{:e}", height(i, j) + slope * i as f64) };
    let row = |j| (0..POINTS).map(|i| value(i, j)).collect::<Vec<String>>().join(" ");
    (0..POINTS).map(row).collect::<Vec<_>>().join("\n").into_bytes()
}

fn options() -> Value {
    json!({
        "size": "1um", "unit": "m", "fill": "harmonic", "detrend": "plane", "young": "70GPa", "poisson": "0.33",
        "p_star": "0.02, 0.05", "boundary": "free",
    })
}

/// Splits a map into its head and its numbers.
fn map(bytes: &[u8]) -> (Value, Vec<f32>) {
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    let head = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
    let numbers = bytes[4 + length..].chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap()));
    (head, numbers.collect())
}

#[test]
fn requests_of_other_sites_hosts_and_tokens_are_refused() {
    let served = Served::start();
    let Served { host, token, .. } = &served;
    let port = host.split_once(':').unwrap().1;
    let answer = |method: &str, host: &str, token: &str, headers: &str| {
        let length = if method == "GET" { "" } else { "Content-Length: 0\n" };
        served.send(
            &format!("{method} /{token}/runs HTTP/1.1\nHost: {host}\nConnection: close\n{length}{headers}\n"),
            &[],
        )
    };
    assert_eq!(answer("GET", host, token, "").status, 200);
    assert_eq!(answer("GET", &format!("localhost:{port}"), token, "Sec-Fetch-Site: none\n").status, 200);
    let other = if token.starts_with('0') { token.replacen('0', "1", 1) } else { token.replacen(&token[..1], "0", 1) };
    let foreign = "Origin: http://evil.example\n";
    for (method, host, token, headers, status) in [
        ("GET", &**host, &*other, "", 404),
        ("GET", host, &token[..31], "", 404),
        ("GET", host, "", "", 404),
        ("GET", &format!("evil.example:{port}"), token, "", 421),
        ("GET", "127.0.0.1", token, "", 421),
        ("GET", "127.0.0.1:1", token, "", 421),
        ("GET", host, token, "Sec-Fetch-Site: cross-site\n", 403),
        ("GET", host, token, foreign, 403),
        ("POST", host, token, foreign, 403),
        ("POST", host, token, "Origin: null\n", 403),
        ("POST", host, token, "Sec-Fetch-Site: same-site\n", 403),
        ("POST", host, token, "Sec-Fetch-Site: none\n", 403),
        ("PUT", host, token, "", 405),
        ("OPTIONS", host, token, foreign, 405),
    ] {
        let found = answer(method, host, token, headers);
        assert_eq!(found.status, status, "{method} {host} {token} {headers}");
        for header in ["cache-control: no-store", "x-content-type-options: nosniff", "default-src 'none'"] {
            assert!(found.head.contains(header), "{}", found.head);
        }
        assert!(!found.head.contains("access-control"), "{}", found.head);
    }
    // A form of another page can send these kinds of content without being asked.
    for kind in ["text/plain", "multipart/form-data", "application/x-www-form-urlencoded"] {
        for path in ["run", "prepare", "upload"] {
            let found = served.ask("POST", path, &format!("Content-Type: {kind}\n"), b"{\"scan\":0}");
            assert_eq!(found.status, 415, "{path} {kind}");
        }
    }
    for path in ["../Cargo.toml", "file/0/result", "map/raw/0", "scan/18446744073709551616", "page.js/", "run/-1"] {
        assert_eq!(served.get(path).status, 404, "{path}");
    }
    let page =
        String::from_utf8(served.get("").body).unwrap() + &String::from_utf8(served.get("page.js").body).unwrap();
    assert!(!page.contains("http://") && !page.contains("https://"), "the page asks no other host");
}

#[test]
fn uploads_are_limited_named_by_the_server_and_read_by_a_reader() {
    let served = Served::start();
    let found = served.upload("..%2F..%2Fetc%2F.pass%20wd.txt", &scan());
    assert_eq!(found.status, 200, "{}", found.error());
    let about = found.json();
    assert_eq!((&about["n"], &about["undefined"]), (&json!([POINTS, POINTS]), &json!(1)));
    assert_eq!(served.upload("C:%5Cpass-wd.txt", &scan()).json()["name"], "pass-wd-2.txt");
    assert_eq!(served.upload("%2E%2E", &scan()).json()["name"], "scan");
    assert_eq!(served.files(), ["pass-wd-2.txt", "pass-wd.txt", "scan"]);
    let large = vec![b'1'; (1 << 20) + 1];
    let refused = served.upload("large.txt", &large);
    assert_eq!((refused.status, refused.error().contains("at most 1 MiB")), (413, true), "{}", refused.error());
    // An upload in chunks, which states no length, is limited, too.
    let Served { host, token, .. } = &served;
    let octets = "Content-Type: application/octet-stream\n";
    let head = format!(
        "POST /{token}/upload HTTP/1.1\nHost: {host}\nConnection: close\n{octets}Transfer-Encoding: chunked\n\n"
    );
    let mut body = format!("{:x}\r\n", large.len()).into_bytes();
    body.extend_from_slice(&large);
    body.extend_from_slice(b"\r\n0\r\n\r\n");
    assert_eq!(served.send(&head, &body).status, 413);
    for hostile in [&b"DIGITAL SURF\xff\xff\xff\xff"[..], b"PK\x03\x04", b"\x89HDF\r\n\x1a\n", b"no numbers", b""] {
        let refused = served.upload("hostile.sur", hostile);
        assert_eq!(refused.status, 422, "{hostile:?}");
        assert!(refused.error().starts_with("hostile.sur: "), "{}", refused.error());
    }
    assert_eq!(served.files().len(), 3, "refused files do not stay: {:?}", served.files());
    assert_eq!(std::fs::read_dir(served.folder.path()).unwrap().count(), 1, "nothing lies beside the folder");
}

#[test]
fn options_that_name_files_outputs_or_threads_are_neither_offered_nor_taken() {
    let served = Served::start();
    served.upload("scan.txt", &scan());
    let form = served.get("form").json();
    let offered: Vec<&Value> = form["options"].as_array().unwrap().iter().collect();
    for key in ["detrend", "level", "fill", "boundary", "young", "pressure", "hardness", "tolerance", "law"] {
        assert!(offered.iter().any(|entry| entry["key"] == key), "{key}");
    }
    for entry in offered {
        assert!(!entry["value"].as_str().unwrap().contains("FILE") && entry["group"] != "Output", "{entry}");
    }
    let before = served.files();
    let outside = served.folder.path().join("outside.h5");
    let outside = outside.to_str().unwrap();
    for (key, value) in [
        ("out", json!(outside)),
        ("vtk", json!("a.vtp")),
        ("surface", json!("/etc/passwd")),
        ("second_surface", json!("/etc/passwd")),
        ("lower_surface", json!("/etc/passwd")),
        ("compliance", json!("/etc/passwd")),
        ("base_displacement", json!("/etc/passwd")),
        ("invalid", json!("/etc/passwd")),
        ("threads", json!("1")),
        ("plots", json!("a")),
        ("resume", json!(true)),
        ("export_law", json!("a.inp")),
        ("no_such", json!("1")),
        ("hardness", json!("/etc/passwd")),
        ("hardness", json!(scan_path(&served))),
        ("young", json!({"a": 1})),
        ("young", json!(3)),
        ("young", json!(format!("1 --out={outside}"))),
        ("poisson", json!("")),
    ] {
        let mut options = options();
        options[key] = value.clone();
        for path in ["run", "prepare"] {
            // `surface` has no body and leaves its options out.
            if path == "prepare" && ["young", "poisson", "hardness"].contains(&key) {
                continue;
            }
            let refused = served.post(path, &json!({ "scan": 0, "options": options }));
            assert_eq!(refused.status, 400, "{path} {key} {value}");
            assert!(!refused.error().is_empty() && !refused.error().contains('\n'), "{}", refused.error());
        }
    }
    assert_eq!(served.post("run", &json!({ "scan": 7, "options": options() })).status, 404);
    assert_eq!(served.post("run", &json!({ "scan": 0, "file": "/etc/passwd" })).status, 400);
    assert_eq!(served.files(), before);
    assert!(!Path::new(outside).exists());
    assert_eq!(served.get("runs").json(), json!([]), "a refused run is no run");
}

fn scan_path(served: &Served) -> String {
    served.results().join("scan.txt").to_str().unwrap().to_owned()
}

#[test]
fn warnings_of_the_preparation_are_told_without_the_path_of_the_folder() {
    let served = Served::start();
    // A tilt that stays makes a step at the seam.
    let number = served.upload("tilted.txt", &tilted(1e-8)).json()["scan"].clone();
    let told = served.post("prepare", &json!({ "scan": number, "options": { "fill": "harmonic" } })).json();
    let warning = told["warnings"][0].as_str().unwrap_or_default();
    assert!(warning.starts_with("tilted.txt: steps across the periodic seam"), "{told}");
    assert!(!told["source"].as_str().unwrap().contains("results"), "{told}");
}

#[test]
fn a_result_is_that_of_the_printed_command_line_bit_for_bit() {
    let served = Served::start();
    let scan_number = served.upload("scan.txt", &scan()).json()["scan"].clone();
    let prepared = served.post("prepare", &json!({ "scan": scan_number, "options": options() }));
    assert_eq!(prepared.status, 200, "{}", prepared.error());
    assert_eq!(prepared.json()["warnings"], json!([]));
    let (head, heights) = map(&served.get("map/prepared/0").body);
    assert_eq!((&head["n"], &head["undefined"], heights.len()), (&json!([POINTS, POINTS]), &json!(0), POINTS * POINTS));
    let (raw, values) = map(&served.get("map/raw/0").body);
    assert_eq!((&raw["undefined"], values[4 * POINTS + 3].is_nan()), (&json!(1), true), "y is the slow axis");

    let started = served.post("run", &json!({ "scan": 0, "options": options() }));
    assert_eq!(started.status, 200, "{}", started.error());
    let about = served.wait(0, &["done", "failed"]);
    assert_eq!(about["state"]["phase"], "done", "{about}");
    let found = &about["state"]["found"];
    assert!(found["sheets"][0]["columns"][0][0].as_str().unwrap().starts_with("pressure / "), "{found}");
    let path = served.results().join(found["file"].as_str().unwrap());
    assert_eq!(std::fs::read(&path).unwrap(), served.get("file/0/result").body);
    assert!(String::from_utf8(served.get("file/0/page").body).unwrap().contains("<svg"));
    assert!(about["python"].as_str().unwrap().contains("gfmd.contact(s, gfmd.Body(young=\"70GPa\""), "{about}");

    let command = about["command"].as_str().unwrap();
    let again = served.results().join("again.h5");
    let words: Vec<String> = command.split(' ').skip(1).map(|word| word.trim_matches('\'').to_owned()).collect();
    let words: Vec<&str> = words.iter().map(|word| &**word).filter(|word| !word.starts_with("--out=")).collect();
    let output =
        gfmd(served.folder.path(), &[&words[..], &["--threads", "1", "--out", again.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(numbers(&path), numbers(&again));
    let config = |path: &Path| Reader::open(path).unwrap().text("/", "config").unwrap();
    assert_eq!(config(&path), config(&again));
    assert_eq!(Reader::open(&path).unwrap().text("/", "command").unwrap(), command);

    // The map of the page has the numbers of the file, in a readable unit.
    let (head, shown) = map(&served.get("map/run/0/pressure/1").body);
    let stored: Vec<f64> = Reader::open(&path).unwrap().slab("/fields/pressure", 1).unwrap();
    let unit = head["unit"].as_str().unwrap();
    let factor = match unit {
        "MPa" => 1e-6,
        "GPa" => 1e-9,
        other => panic!("{other}"),
    };
    for (i, j) in [(0, 0), (5, 7), (23, 1), (12, 20)] {
        let expected = stored[i * POINTS + j] * factor;
        let found = f64::from(shown[j * POINTS + i]);
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} {expected}");
    }
    assert!(shown.iter().any(|pressure| *pressure > 0.0));
    // A part has its numbers, and ends at its edge.
    let (part, seen) = map(&served.get("map/run/0/pressure/1/part/3/5/4/1000").body);
    assert_eq!((&part["from"], &part["n"]), (&json!([3, 5]), &json!([4, POINTS - 5])));
    assert_eq!(seen[4 + 1], shown[6 * POINTS + 4]);
    for path in ["map/run/0/pressure/2", "map/run/0/..%2Fsurface/0", "map/run/0/no_field/0"] {
        assert_eq!(served.get(path).status, 400, "{path}");
    }
}

/// Enough loads for many seconds.
fn many_loads() -> Value {
    let mut all = options();
    all["p_star"] = json!("0.0001:0.5:4000");
    json!({ "scan": 0, "options": all })
}

#[test]
fn two_runs_go_at_once_others_wait_and_all_can_be_stopped() {
    let mut served = Served::start();
    served.upload("scan.txt", &scan());
    for run in 0..4 {
        assert_eq!(served.post("run", &many_loads()).json()["run"], run);
    }
    served.wait(0, &["running"]);
    served.wait(1, &["running"]);
    let began = Instant::now();
    while [0, 1].iter().any(|run| served.get(&format!("run/{run}")).json()["progress"]["share"] == 0.0) {
        assert!(began.elapsed() < PATIENCE, "both go on");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(served.get("run/2").json()["state"]["phase"], "waiting");
    // A run that waits is stopped at once; one that goes ends, and the next one begins.
    assert_eq!(served.post("stop/2", &json!({})).status, 200);
    assert_eq!(served.get("run/2").json()["state"]["phase"], "stopped");
    served.post("stop/0", &json!({}));
    let stopped = served.wait(0, &["stopped"]);
    assert!(stopped["state"]["message"].as_str().unwrap().contains("--resume continues"), "{stopped}");
    assert!(stopped["state"]["found"]["loads"].as_u64().unwrap() > 0, "{stopped}");
    served.wait(3, &["running"]);
    // It goes on under its number, and only once.
    assert_eq!(served.post("resume/0", &json!({})).status, 200);
    assert_eq!(served.post("resume/0", &json!({})).status, 400);
    assert_eq!(served.post("resume/9", &json!({})).status, 404);
    assert_eq!(served.get("run/0").json()["state"]["phase"], "waiting");
    served.post("stop/1", &json!({}));
    served.wait(0, &["running"]);
    #[cfg(unix)]
    {
        // Ctrl-C ends the server after its runs, which keep their finished loads.
        let id = served.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert_eq!(served.child.wait().unwrap().code(), Some(0));
        let kept = served.files().into_iter().filter(|name| name.ends_with(".journal")).count();
        assert!(kept >= 2, "{:?}", served.files());
    }
    #[cfg(not(unix))]
    served.child.kill().unwrap();
}

#[test]
fn flags_that_cannot_be_used_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let taken = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    for (words, told) in [
        (&["--port", &*port][..], format!("--port: {port}: ")),
        (&["--folder", "file"], "--folder: file: ".into()),
        (&["--upload-limit", "0"], "--upload-limit is 0; it must be at least 1".into()),
    ] {
        let output = gfmd(folder.path(), &[&["serve"], words].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(&told), "{words:?}: {said}");
    }
}
