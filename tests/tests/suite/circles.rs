//! No circular dependencies: within a module, its submodules use each other in one direction. A module and its contents
//! count as one; tests within a file do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

type Module = Vec<String>;

/// Returns the modules of a crate, with the text of each without comments and tests.
fn modules(src: &Path) -> BTreeMap<Module, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![src.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let place = path.strip_prefix(src).unwrap().with_extension("");
                let place: Module = place.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
                let place = if place == ["lib"] { Vec::new() } else { place };
                let text = std::fs::read_to_string(&path).unwrap();
                let text = text.split("#[cfg(test)]").next().unwrap_or_default();
                let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
                found.insert(place, lines.collect::<Vec<_>>().join(" "));
            }
        }
    }
    found
}

/// Returns the paths that a text uses, from `crate` or `super`: paths of `use` with expanded braces, and paths in code.
fn paths(text: &str) -> Vec<Module> {
    let mut found = Vec::new();
    for start in ["crate::", "super::"].iter().flat_map(|word| text.match_indices(word).map(|(at, _)| at)) {
        let before = text[..start].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let end = text[start..].find(|c: char| !(c.is_alphanumeric() || "_:{}, ".contains(c)));
        open(&[], &text[start..end.map_or(text.len(), |end| start + end)], &mut found);
    }
    found
}

/// Expands `a::{b, c::d}`; ends at the end of the first path.
fn open(before: &[String], text: &str, found: &mut Vec<Module>) {
    let mut path = before.to_vec();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        if let Some(inside) = rest.strip_prefix('{') {
            let (mut depth, mut from) = (0, 0);
            for (at, c) in inside.char_indices() {
                match c {
                    '{' => depth += 1,
                    ',' | '}' if depth == 0 => {
                        open(&path, &inside[from..at], found);
                        from = at + 1;
                        if c == '}' {
                            return;
                        }
                    }
                    '}' => depth -= 1,
                    _ => {}
                }
            }
            return;
        }
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        if end > 0 {
            path.push(rest[..end].to_owned());
        }
        match rest[end..].strip_prefix("::") {
            Some(more) => rest = more,
            None => return found.push(path),
        }
    }
}

/// Returns the module of a path that is written in `own`.
fn target(own: &Module, path: &[String], all: &BTreeMap<Module, String>) -> Module {
    let up = path.iter().take_while(|part| *part == "super").count();
    let (mut place, rest) = match path {
        [first, rest @ ..] if first == "crate" => (Vec::new(), rest),
        _ => (own[..own.len().saturating_sub(up)].to_vec(), &path[up..]),
    };
    for part in rest {
        place.push(part.clone());
        if !all.contains_key(&place) {
            place.pop();
            break;
        }
    }
    place
}

/// Returns a circle among the places that use others, if there is one.
fn circle(uses: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    let mut left = uses.clone();
    // Places that use no others, or are used by none, are in no circle.
    loop {
        let ends: Vec<String> =
            left.keys().filter(|place| left[*place].iter().all(|used| !left.contains_key(used))).cloned().collect();
        if ends.is_empty() {
            return (!left.is_empty()).then(|| left.into_keys().collect());
        }
        ends.iter().for_each(|end| drop(left.remove(end)));
    }
}

/// Returns the circles of a crate.
fn circles(all: &BTreeMap<Module, String>) -> Vec<String> {
    let mut uses: BTreeMap<Module, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (own, text) in all {
        for used in paths(text).iter().map(|path| target(own, path, all)) {
            let shared = own.iter().zip(&used).take_while(|(a, b)| a == b).count();
            if let (Some(a), Some(b)) = (own.get(shared), used.get(shared)) {
                uses.entry(own[..shared].to_vec()).or_default().entry(a.clone()).or_default().insert(b.clone());
            }
        }
    }
    let found = uses.iter().filter_map(|(parent, uses)| Some((parent, circle(uses)?)));
    found.map(|(parent, names)| format!("{}: {}", parent.join("/"), names.join(", "))).collect()
}

#[test]
fn the_files_of_no_crate_use_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources: Vec<PathBuf> =
        std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path()).collect();
    sources.push(root.join("xtask"));
    let mut count = 0;
    for source in sources.iter().map(|folder| folder.join("src")).filter(|source| source.is_dir()) {
        let all = modules(&source);
        count += all.len();
        let found = circles(&all);
        assert!(found.is_empty(), "{}: {}", source.display(), found.join("; "));
    }
    assert!(count > 300, "{count} files");
}

#[test]
fn a_circle_is_found() {
    let files = |texts: &[(&str, &str)]| -> BTreeMap<Module, String> {
        texts.iter().map(|(place, text)| (place.split('/').map(Into::into).collect(), (*text).to_owned())).collect()
    };
    let one_way = files(&[
        ("a", "use crate::b::{C, d::{E, F}};"),
        ("b", "fn f() {}"),
        ("b/d", "use super::C; crate::e::g()"),
        ("e", ""),
    ]);
    assert_eq!(circles(&one_way), Vec::<String>::new());
    let round = files(&[
        ("a", "use crate::{b::C, e};"),
        ("b", "mod d;"),
        ("b/d", "fn f() { crate::e::g() }"),
        ("e", "use crate::a::A;"),
    ]);
    assert_eq!(circles(&round), [": a, b, e"]);
    let inside = files(&[("b", ""), ("b/c", "use super::d::D;"), ("b/d", "use super::{X, c::{Y, Z}};")]);
    assert_eq!(circles(&inside), ["b: c, d"]);
}
