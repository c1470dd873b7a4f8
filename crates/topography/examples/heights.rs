//! Writes the height maps that the readers find in a file, for comparison with other programs: one JSON line per height
//! map, and its heights as `FOLDER/NUMBER.npy`.
//!
//! ```text
//! cargo run --release -p gfmd-topography --example heights -- FILE FOLDER
//! ```
#![allow(clippy::print_stdout, reason = "the lines are the output")]

use std::path::Path;
use std::process::ExitCode;

use gfmd_files::{Output, npy};
use gfmd_topography::Topography;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, file, folder] = &arguments[..] else {
        println!("usage: heights FILE FOLDER");
        return ExitCode::from(2);
    };
    match write(file, Path::new(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            println!("{{\"error\": {}}}", quoted(&error.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn write(file: &str, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let listing = Topography::list(file)?;
    for (number, channel) in listing.channels.iter().enumerate() {
        let map = match Topography::read(file, Some(&number.to_string())) {
            Ok(map) => map,
            Err(error) => {
                println!("{{\"name\": {}, \"error\": {}}}", quoted(&channel.name), quoted(&error.to_string()));
                continue;
            }
        };
        npy::write(&Output::claim(folder.join(format!("{number}.npy")))?, map.heights.view().into_dyn())?;
        let lengths = map.lengths.map_or("null".into(), |lengths| format!("{lengths:?}"));
        // A container has data files of other formats.
        let inner = map.notes.iter().find_map(|note| note.split_once(" has the format "));
        let data_format = inner.map_or(listing.format, |(_, format)| format);
        let text = |text: &Option<String>| text.as_deref().map_or("null".into(), quoted);
        println!(
            "{{\"format\": {}, \"data_format\": {}, \"number\": {number}, \"name\": {}, \"default\": {}, \"lengths\": \
             {lengths}, \"unit\": {}, \"undefined\": {}, \"conversion\": {}}}",
            quoted(listing.format),
            quoted(data_format),
            quoted(&channel.name),
            listing.default == Some(number),
            text(&map.unit),
            map.undefined,
            text(&map.conversion),
        );
    }
    Ok(())
}

/// Quotes a text as JSON.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            character if u32::from(character) < 32 => quoted.push_str(&format!("\\u{:04x}", u32::from(character))),
            character => quoted.push(character),
        }
    }
    quoted + "\""
}
