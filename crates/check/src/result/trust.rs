//! Parts of a result, and how `check` verifies each of them. docs/trust.md is generated from this table.

use std::fmt::Write as _;

use super::ResultKind;

/// Ways to verify a part of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// Every change beyond rounding is noticed, even with a correct checksum.
    Verified,
    /// Some changes are noticed, even with a correct checksum.
    InPart,
    /// Only the checksum notices a change.
    Checksum,
}

impl Coverage {
    fn name(self) -> &'static str {
        match self {
            Self::Verified => "verified",
            Self::InPart => "in part",
            Self::Checksum => "checksum only",
        }
    }
}

/// Parts of a result, and how they are verified.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Variables as `/group/name`, attributes as `/group@name` or `/group/name@name`; `*` stands for any letters.
    pub parts: &'static [&'static str],
    /// Verification without `--rerun`.
    pub plain: Coverage,
    /// Verification with `--rerun`.
    pub rerun: Coverage,
    /// Data or computation for the comparison; empty for none.
    pub by: &'static str,
}

const fn row(parts: &'static [&'static str], plain: Coverage, rerun: Coverage, by: &'static str) -> Row {
    Row { parts, plain, rerun, by }
}

use Coverage::{Checksum, InPart, Verified};

/// Rows of all kinds of results.
const ALL: &[Row] = &[
    row(&["@schema_version"], Verified, Verified, "the version of the program"),
    row(&["@content_sha256"], Verified, Verified, "the whole content"),
    row(&["@config"], InPart, InPart, "keys and types; values on which verified parts depend"),
    row(
        &[
            "@program",
            "@version",
            "@git_commit",
            "@command",
            "@created",
            "@machine",
            "@threads",
            "@warnings",
            "@seconds",
        ],
        Checksum,
        Checksum,
        "",
    ),
    row(&["/*@undefined", "/history/*@*", "/not_converged/*@*"], Checksum, Verified, "the second run"),
    row(&["/*@units", "/*@long_name"], Verified, Verified, "the layout that the configuration gives"),
];

/// Rows of the surface of a contact or a path.
const SURFACE: &[Row] = &[
    row(&["/surface/height"], Verified, Verified, "height_sha256, the fields, the generator of generated heights"),
    row(
        &["/surface@rms_gradient", "/surface@boundary", "/surface@height_sha256", "/surface@size_*"],
        Verified,
        Verified,
        "the heights and the configuration",
    ),
    row(&["/surface@description"], InPart, InPart, "the generator of generated heights"),
    row(
        &["/surface@file", "/surface@file_sha256", "/surface@second_file", "/surface@second_file_sha256"],
        InPart,
        InPart,
        "the file, if it exists",
    ),
    row(&["/surface/hardness"], InPart, InPart, "the loads, where the hardness is reached"),
    row(&["/surface/preparation/shifts", "/surface/preparation/scan_line"], Checksum, Checksum, ""),
    row(&["/surface@*"], Checksum, Checksum, ""),
];

/// Rows of the record of a search, and of a failed search.
const SEARCH: &[Row] =
    &[row(&["/history/*", "/history@*", "/not_converged/*", "/not_converged@*"], Checksum, Verified, "the second run")];

const CONTACT: &[Row] = &[
    row(&["/loads/seconds"], Checksum, Checksum, ""),
    row(
        &[
            "/loads/iterations",
            "/loads/transform_pairs",
            "/loads/passed_instability",
            "/loads/lowest_curvature",
            "/loads/residual_lateral_traction",
            "/flow_threshold/*",
            "/flow_threshold*@*",
        ],
        Checksum,
        Verified,
        "the second run",
    ),
    row(
        &["/loads/residual_*", "/loads/lower_residual_*", "/loads/stiffness_error", "/loads/flow_residual"],
        InPart,
        Verified,
        "the fields of the load, to 1e-3; their bounds",
    ),
    row(&["/loads/*"], Verified, Verified, "the fields of the load; without fields only the second run"),
    row(&["/fields/*"], Verified, Verified, "the pressure, with a law also the gap, on surface and body"),
    row(&["/patches/*", "/distributions/*", "/spectra/*"], Verified, Verified, "the fields of the loads"),
];

/// Rows of a base that moves.
const BASE: &[Row] = &[
    row(&["/base/displacement", "/base/traction", "/base/lift"], Verified, Verified, "the body over this base"),
    row(&["/base/*"], Verified, Verified, "the layout that the configuration gives"),
];

/// Rows of the second surface of a slab.
const LOWER: &[Row] = &[
    row(
        &["/lower/height", "/lower@height_sha256"],
        Verified,
        Verified,
        "each other, the generator of generated heights",
    ),
    row(&["/lower@rms_gradient", "/lower@boundary", "/lower@size_*"], Verified, Verified, "the heights"),
    row(&["/lower/*"], Verified, Verified, "the layout that the configuration gives"),
    row(&["/lower@description"], InPart, InPart, "the generator of generated heights"),
    row(&["/lower@*"], Checksum, Checksum, ""),
];

const PATH: &[Row] = &[
    row(&["/history/index", "/history/x", "/history/y"], Verified, Verified, "the layout that the configuration gives"),
    row(
        &["/history/displacement", "/history/lower_displacement"],
        Verified,
        Verified,
        "the displacement of the last step",
    ),
    row(
        &["/history/branch", "/history/lower_branch"],
        Verified,
        Verified,
        "the pressure of the last step, computed from it and the displacement",
    ),
    row(&["/path/seconds"], Checksum, Checksum, ""),
    row(
        &["/path/converged", "/path/p_star", "/path/lateral_*"],
        Verified,
        Verified,
        "the residual and the tolerance; the mean pressure; the waypoints of the configuration",
    ),
    row(
        &["/path/iterations", "/path/transform_pairs", "/path/passed_instability", "/path/lowest_curvature"],
        Checksum,
        Verified,
        "the second run",
    ),
    row(
        &["/path/dissipated", "/path/dissipated_error", "/path/work_imbalance", "/path/extra_solves"],
        InPart,
        Verified,
        "the balance of work and energy (viscoelastic bodies, and laws with an energy, undivided steps); zero for a \
         hard wall on an elastic body",
    ),
    row(&["/path/step"], Verified, Verified, "the layout that the configuration gives"),
    row(
        &["/path/*"],
        InPart,
        Verified,
        "the waypoints of the configuration; the fields there; elastic_energy of a viscoelastic body at the last step \
         from the history, unless boundaries are free",
    ),
    row(&["/fields/*"], Verified, Verified, "each other, on surface and body"),
    row(&["/patches/*", "/distributions/*", "/spectra/*"], Verified, Verified, "the fields at the waypoints"),
];

const SLIDE: &[Row] = &[
    row(&["/states/seconds"], Checksum, Checksum, ""),
    row(&["/states/iterations", "/states/transform_pairs"], Checksum, Verified, "the second run"),
    row(
        &["/states/*_limit", "/states/*_limit_error", "/states/*_grid_error"],
        Checksum,
        Verified,
        "the second run, on the finer grid, too",
    ),
    row(
        &["/states/residual", "/states/heat_residual"],
        InPart,
        Verified,
        "the pressure and the flux of heat, to 1e-3; their bound",
    ),
    row(&["/states/*"], Verified, Verified, "the pressure of the state; the configuration"),
    row(&["/fields/temperature", "/fields/heat_flux"], Verified, Verified, "each other, and the pressure"),
    row(&["/fields/*"], Verified, Verified, "the pressure, on surface and body"),
];

const PUNCH: &[Row] = &[
    row(&["/refinement/*"], Checksum, Verified, "the second run, on all grids"),
    row(&["/punch/seconds"], Checksum, Checksum, ""),
    row(&["/punch/iterations", "/punch/transform_pairs"], Checksum, Verified, "the second run"),
    row(&["/punch/residual"], InPart, Verified, "the traction, to 1e-3; its bound"),
    row(&["/punch/*"], Verified, Verified, "the traction"),
    row(&["/fields/under_punch"], InPart, InPart, "the configuration; with --mask it is an input"),
    row(&["/fields/*"], Verified, Verified, "the traction, on the body"),
];

const BODY: &[Row] = &[
    row(&["/input@*"], InPart, InPart, "the file, if it exists"),
    row(&["/fields/*", "/fields@*"], Verified, Verified, "a second run, if the input exists; else nothing"),
];

const SWEEP: &[Row] = &[
    row(
        &["/runs/iterations", "/runs/transform_pairs", "/runs/seconds"],
        Checksum,
        InPart,
        "the runs that are repeated",
    ),
    row(
        &["/runs/kappa", "/runs/kappa_corrected", "/runs/area_fraction", "/runs/p_star"],
        Verified,
        Verified,
        "each other, points and fits",
    ),
    row(
        &[
            "/runs/run",
            "/runs/point",
            "/runs/realisation",
            "/runs/p_star_asked",
            "/runs/seed",
            "/runs/hurst",
            "/runs/eps_*",
            "/runs/n",
        ],
        Verified,
        Verified,
        "the configuration",
    ),
    row(&["/runs/*"], InPart, InPart, "bounds of the residuals; the runs that are repeated"),
    row(&["/points/*", "/fit/*", "/protocol/*", "/theory/*"], Verified, Verified, "the runs"),
    row(
        &["/example/height", "/example/pressure", "/example@seed"],
        InPart,
        Verified,
        "its equilibrium; the second run",
    ),
    row(&["/example/*", "/example@*"], Verified, Verified, "the configuration"),
];

const STUDY: &[Row] = &[
    row(
        &["/study/surface", "/study/seed", "/study/body", "/study/status", "/study@command"],
        Verified,
        Verified,
        "the configuration; each other",
    ),
    row(
        &["/study/load", "/study/velocity", "/study/step", "/study/error"],
        InPart,
        InPart,
        "the configuration, unless surfaces are in files; the status",
    ),
    row(&["/study/warnings", "/study/config", "/study@*", "/study/*@*"], Checksum, Checksum, ""),
    row(&["/study/*"], Checksum, InPart, "the members that are repeated; not of surfaces in files"),
];

/// Returns the rows of a kind. The first row that matches a part applies to it.
pub fn rows(kind: ResultKind) -> impl Iterator<Item = &'static Row> {
    let own: &[&[Row]] = match kind {
        ResultKind::Contact => &[SEARCH, CONTACT, BASE, LOWER, ALL, SURFACE],
        ResultKind::Path => &[PATH, SEARCH, BASE, LOWER, ALL, SURFACE],
        ResultKind::Slide => &[SLIDE, ALL, SURFACE],
        ResultKind::Punch => &[SEARCH, ALL, PUNCH],
        ResultKind::Body => &[ALL, BODY],
        ResultKind::KappaSweep => &[ALL, SWEEP],
        ResultKind::Study => &[STUDY, ALL],
    };
    own.iter().copied().flatten()
}

/// Returns the row of a part of a result; `None` if no result of the kind has this part.
pub fn row_of(kind: ResultKind, part: &str) -> Option<&'static Row> {
    rows(kind).find(|row| row.parts.iter().any(|pattern| fits(pattern, part)))
}

/// Returns true if a part matches a pattern. Variables match no attribute pattern, and attributes no variable pattern.
fn fits(pattern: &str, part: &str) -> bool {
    pattern.contains('@') == part.contains('@') && matches(pattern, part)
}

fn matches(pattern: &str, text: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == text,
        Some((before, after)) => text.strip_prefix(before).is_some_and(|rest| {
            let ends = rest.char_indices().map(|(end, _)| end).chain([rest.len()]);
            ends.into_iter().any(|end| matches(after, &rest[end..]))
        }),
    }
}

/// Returns the page docs/trust.md: parts that are not verified in full, and verified ones that a pattern of the former
/// fits.
pub fn page() -> String {
    let tables = [
        ("Every result", ALL),
        ("Surface of `contact`, `path` and `slide`", SURFACE),
        ("Lower surface of `contact` and `path`", LOWER),
        ("Base of `contact` and `path`, if it moves", BASE),
        ("Search of `contact`, `path` and `punch`", SEARCH),
        ("`contact`", CONTACT),
        ("`path`", PATH),
        ("`slide`", SLIDE),
        ("`punch`", PUNCH),
        ("`body`", BODY),
        ("`kappa-sweep`", SWEEP),
        ("`study`", STUDY),
    ];
    let is_verified = |row: &Row| [row.plain, row.rerun] == [Verified; 2];
    let all = tables.iter().flat_map(|(_, rows)| rows.iter());
    let open: Vec<&str> = all.filter(|row| !is_verified(row)).flat_map(|row| row.parts).copied().collect();
    let is_shown = |row: &&Row| !is_verified(row) || row.parts.iter().any(|part| open.iter().any(|of| fits(of, part)));
    let mut page = String::from(include_str!("trust.md"));
    for (title, rows) in tables {
        let rows: Vec<&Row> = rows.iter().filter(is_shown).collect();
        if rows.is_empty() {
            continue;
        }
        let _ = write!(page, "\n## {title}\n\n| part | `check` | `check --rerun` | by |\n|---|---|---|---|\n");
        for Row { parts, plain, rerun, by } in rows {
            let parts = parts.iter().map(|part| format!("`{part}`")).collect::<Vec<_>>().join(", ");
            let by = if by.is_empty() { "-" } else { by };
            let _ = writeln!(page, "| {parts} | {} | {} | {by} |", plain.name(), rerun.name());
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use gfmd_record::{COLUMNS, Origin};

    use super::*;

    /// Checks that times are not compared, since a second run takes another time.
    #[test]
    fn numbers_of_the_clock_are_not_compared() {
        let clocks = COLUMNS.iter().filter(|column| column.origin == Origin::Clock);
        let parts: Vec<(ResultKind, String)> = clocks
            .flat_map(|column| {
                [(ResultKind::Contact, "loads"), (ResultKind::Path, "path")].map(|(kind, group)| (kind, group, column))
            })
            .map(|(kind, group, column)| (kind, format!("/{group}/{}", column.name)))
            .collect();
        assert!(!parts.is_empty());
        for (kind, part) in parts {
            assert_eq!(row_of(kind, &part).map(|row| row.rerun), Some(Checksum), "{part}");
        }
    }

    #[test]
    fn the_first_row_that_fits_is_that_of_a_part() {
        let plain = |kind, part| row_of(kind, part).map(|row| row.plain);
        assert_eq!(plain(ResultKind::Contact, "/loads/seconds"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/loads/kappa"), Some(Verified));
        assert_eq!(plain(ResultKind::Contact, "/loads/kappa@units"), Some(Verified));
        assert_eq!(plain(ResultKind::Contact, "/history/energy@units"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/flow_threshold/x@units"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/lower/height@units"), Some(Verified));
        assert_eq!(plain(ResultKind::Contact, "@created"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/surface@size_x"), Some(Verified));
        assert_eq!(plain(ResultKind::Contact, "/surface@format"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/surface@a/b"), Some(Checksum));
        assert_eq!(plain(ResultKind::Contact, "/surface/x"), None);
        assert_eq!(plain(ResultKind::Contact, "/evil/x"), None);
        assert_eq!(plain(ResultKind::Contact, "@evil"), None);
        assert_eq!(plain(ResultKind::Punch, "/loads/kappa"), None);
    }
}
