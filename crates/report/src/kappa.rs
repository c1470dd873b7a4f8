//! Page about a sweep. The numbers are read from the file; the figures are drawn from its runs.

pub mod figures;

use gfmd_files::Reader;
use gfmd_green::BaseKind;
use gfmd_sweep::{Alpha, Analysis, BodyConfig, Config, Method, Plan, StatisticsConfig, Study};
use maud::{Markup, html};

use crate::figures::{field, pressure};
use crate::page::{Certificate, Fact, Page, Stored, Table, config, interval, number, text, transforms, whole};
use gfmd_check::result::Comparison;
use gfmd_check::sweep::{example, runs};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

const CITED: [&str; 5] = [
    "N. Prodanov, W. B. Dapp, M. H. Müser, On the contact area and mean gap of rough, elastic contacts: dimensional \
     analysis, numerical corrections, and reference data, Tribology Letters 53, 433–448 (2014): the three limits.",
    "C. Campañá, M. H. Müser, Practical Green’s function approach to the simulation of elastic semi-infinite solids, \
     Physical Review B 74, 075420 (2006).",
    "V. A. Yastrebov, G. Anciaux, J.-F. Molinari, On the accurate computation of the true contact-area in mechanical \
     contact of random rough surfaces, Tribology International 114, 161–171 (2017): the perimeter correction.",
    "B. N. J. Persson, Theory of rubber friction and contact mechanics, Journal of Chemical Physics 115, 3840–3861 \
     (2001).",
    "A. W. Bush, R. D. Gibson, T. R. Thomas, The elastic contact of a rough surface, Wear 35, 87–111 (1975).",
];

/// Builds the page about the sweep in a file.
///
/// # Errors
/// Returns an error if the file has no fit or no runs.
pub fn page(reader: &Reader, session: &Session) -> Result<Page, Failure> {
    let fits = Stored::new(reader, "/fit", "kappa_tfc")?;
    let loads = Stored::new(reader, "/runs", "mean_pressure")?;
    let mut page = Page { title: "κ, extrapolated".into(), cited: CITED.to_vec(), ..Page::default() };
    answer(&mut page, reader, &fits);
    protocols(&mut page, reader);
    points(&mut page, reader)?;
    let config = reader.text("/", "config").unwrap_or_default();
    match toml::from_str::<Config>(&config) {
        Ok(config) => {
            asked(&mut page, &config);
            let tolerance = config.solver.tolerance;
            for name in loads.names("residual_") {
                let (largest, name) = (loads.worst(&name), name.trim_start_matches("residual_").replace('_', " "));
                page.certificates.push(Certificate { name, largest, allowed: tolerance });
            }
            if let Err(failure) = drawn(&mut page, reader, config, fits.column("kappa_tfc").first().copied(), session) {
                page.remarks.push(format!("the figures are not drawn: {failure}"));
            }
        }
        Err(error) => {
            page.remarks.push(format!("no figures; this version cannot read the configuration: {}", error.message()))
        }
    }
    page.cost.push(Fact(html! { "contacts" }, whole(loads.len() as f64)));
    page.cost.push(Fact(html! { "transform pairs" }, transforms(loads.sum("transform_pairs"))));
    if let Ok(seconds) = reader.number("/", "seconds") {
        page.cost.push(Fact(html! { "time of the last session" }, html! { (number(seconds)) " s" }));
    }
    Ok(page)
}

/// Formats κ with an index.
fn kappa(index: &str) -> Markup {
    html! { i { "κ" } sub { (index) } }
}

/// Adds the result and a table of all fits.
fn answer(page: &mut Page, reader: &Reader, fits: &Stored) {
    let column = |name: &str| fits.column(name);
    let areas = reader.texts("/fit/area").unwrap_or_default();
    let uncertainty = reader.texts("/fit/uncertainty").unwrap_or_default();
    let [hurst, p_star, value] = ["hurst", "p_star", "kappa_tfc"].map(column);
    let ends = |of: &str| -> Vec<[f64; 2]> {
        column(&format!("{of}_low")).into_iter().zip(column(&format!("{of}_high"))).map(|(a, b)| [a, b]).collect()
    };
    let (statistical, total) = (ends("kappa_tfc_ci95"), ends("kappa_tfc_total_ci95"));
    let [systematic, chi, freedom] = ["kappa_tfc_systematic", "chi_squared", "degrees_of_freedom"].map(column);
    let is_slope = config(reader).get("fit").and_then(|fit| fit.get("estimator")?.as_str()) == Some("slope");
    let (Some(&first), Some(&at)) = (value.first(), p_star.first()) else { return };
    let [low, high] = total[0];
    page.answer.push(html! {
        p.headline {
            (kappa("TFC")) " = " (number(first)) " " (interval([low, high])) " "
            span { "H = " (hurst[0]) ", " i { "p" } "* = " (at) }
        }
    });
    page.answer.push(html! {
        p {
            @if is_slope {
                "κ = " i { "E" } "* " i { "g" } " d" i { "a" } sub { "r" } "/d" i { "p" } ", the slope over all loads,"
            } @else { "κ = " i { "a" } sub { "r" } " " i { "E" } "* " i { "g" } "/" i { "p" } }
            " in the thermodynamic, fractal and continuum limit. "
            @if low.is_finite() && high.is_finite() {
                "The interval is that of 95 % with the error of the form of the fit; the statistical one is "
                (interval(statistical[0]))
                ", the error of the form is " (number(systematic[0])) ". "
            } @else { strong { "It has no interval. " } }
            "χ² is " (number(chi[0])) " with " (whole(freedom[0])) " degrees of freedom. "
            @if let Some(source) = uncertainty.first() { "Source of the interval: " (text(source)) "." }
        }
    });
    if chi[0] > freedom[0] + 3.0 * (2.0 * freedom[0]).sqrt() {
        page.remarks.push("the fit of the result misses its points by more than their scatter allows (χ²)".into());
    }
    page.tables.push(Table {
        caption: html! { "Every fit; the first is the result. The total interval has the error of the form." },
        head: vec![
            html! { i { "H" } },
            html! { i { "p" } "*" },
            html! { "area" },
            kappa("TFC"),
            html! { "statistical, 95 %" },
            html! { "error of form" },
            html! { "total" },
            html! { "χ²" },
            html! { "d.o.f." },
        ],
        rows: (0..fits.len())
            .map(|row| {
                vec![
                    html! { (hurst[row]) },
                    html! { (p_star[row]) },
                    html! { (text(areas.get(row).map_or("", String::as_str))) },
                    number(value[row]),
                    interval(statistical[row]),
                    number(systematic[row]),
                    interval(total[row]),
                    number(chi[row]),
                    whole(freedom[row]),
                ]
            })
            .collect(),
    });
}

/// Adds a table of the one-axis extrapolations, if the file has any.
fn protocols(page: &mut Page, reader: &Reader) {
    let Ok(stored) = Stored::new(reader, "/protocol", "kappa_tfc") else { return };
    let column = |name: &str| stored.column(name);
    let cells = ["eps_t_inv", "eps_f_inv", "eps_c_inv"].map(column);
    let named = ["kappa_sim", "coefficient_f", "exponent_f", "coefficient_c", "exponent_c", "kappa_tfc"];
    let numbers =
        named.map(|name| (column(name), column(&format!("{name}_ci95_low")), column(&format!("{name}_ci95_high"))));
    let symbol = |letter: &str, index: &str| html! { i { (letter) } sub { (index) } };
    page.tables.push(Table {
        caption: html! {
            "One axis at a time about reference cells 1/ε = (t, f, c); intervals: 95 %, without the misfit of the form."
        },
        head: vec![
            html! { "cell" },
            kappa("sim"),
            symbol("C", "f"),
            symbol("α", "f"),
            symbol("C", "c"),
            symbol("α", "c"),
            kappa("TFC"),
        ],
        rows: (0..stored.len())
            .map(|row| {
                let cell = html! { (cells[0][row]) ", " (cells[1][row]) ", " (cells[2][row]) };
                let number = |(value, low, high): &(Vec<f64>, Vec<f64>, Vec<f64>)| {
                    html! { (number(value[row])) br; small { (interval([low[row], high[row]])) } }
                };
                [cell].into_iter().chain(numbers.iter().map(number)).collect()
            })
            .collect(),
    });
}

/// Adds a table of the points.
fn points(page: &mut Page, reader: &Reader) -> Result<(), Failure> {
    let stored = Stored::new(reader, "/points", "kappa")?;
    let names = ["hurst", "eps_t_inv", "eps_f_inv", "eps_c_inv", "n", "realisations", "p_star"];
    let plain = names.map(|name| stored.column(name));
    let measured = ["kappa", "kappa_sem", "kappa_corrected", "kappa_corrected_sem"].map(|name| stored.column(name));
    let inverse = |index: &str| html! { "1/ε" sub { (index) } };
    page.tables.push(Table {
        caption: html! { "κ of every discretisation and load, mean ± standard error over the surfaces." },
        head: vec![
            html! { i { "H" } },
            inverse("t"),
            inverse("f"),
            inverse("c"),
            html! { i { "n" } },
            html! { "surfaces" },
            html! { i { "p" } "*" },
            html! { "κ" },
            html! { "±" },
            html! { "corrected" },
            html! { "±" },
        ],
        rows: (0..stored.len())
            .map(|row| {
                let plain = plain.iter().map(|column| html! { (column[row]) });
                plain.chain(measured.iter().map(|column| number(column[row]))).collect()
            })
            .collect(),
    });
    Ok(())
}

fn asked(page: &mut Page, config: &Config) {
    let list = |values: &[f64]| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let Config { surface, body, points, loads, statistics, solver, fit } = config;
    let method = match (surface.method, surface.roll_off) {
        (Method::Psd, 1.0) => String::new(),
        (method, roll_off) => format!(", method {method:?}, roll-off at {roll_off} of the longest wavelength"),
    };
    let kind = match (surface.dim, surface.aspect) {
        (2, _) => "profiles in plane strain".to_owned(),
        (_, 1.0) => "isotropic surfaces".to_owned(),
        (_, aspect) => format!("surfaces with the aspect ratio {aspect}, lay {}°", surface.lay),
    };
    let kind = match &surface.marginal {
        Some(marginal) => format!("{kind}, heights {}", marginal.name()),
        None => kind,
    };
    let height = match body.height {
        gfmd_green::Height::Infinite => "half-space".to_owned(),
        gfmd_green::Height::Finite(height) => format!("slab of {height} cell lengths"),
    };
    let word = |alpha: Alpha| match alpha {
        Alpha::Fixed(value) => value.to_string(),
        Alpha::Free => "fitted".into(),
        Alpha::Without => "no term".into(),
        Alpha::SelfAffine if surface.hurst.iter().all(|hurst| config.composes(*hurst)) => {
            "that of the difference of two closures, long waves composed".into()
        }
        Alpha::SelfAffine => "1 − H".into(),
        Alpha::Edge => "measured edge".into(),
    };
    page.asked.extend([
        Fact::new(
            "surfaces",
            &format!(
                "self-affine Gaussian {kind}, H = {}, rms gradient {}{method}",
                list(&surface.hurst),
                surface.rms_gradient
            ),
        ),
        Fact::new(
            "elastic body",
            &format!("{height}, Young’s modulus {}, Poisson’s ratio {}{}", body.young, body.poisson, others(body)),
        ),
        Fact::new("1/ε of the cell (t)", &list(&points.eps_t_inv)),
        Fact::new("1/ε of the roughness (f)", &list(&points.eps_f_inv)),
        Fact::new("1/ε of the grid (c)", &list(&points.eps_c_inv)),
        Fact::new("reduced pressures p*", &format!("{}; result at {}", list(&loads.p_star), fit.p_star)),
        Fact::new("number of surfaces", &surfaces(statistics)),
        Fact::new("exponents α (t, f, c)", &[fit.alpha_t, fit.alpha_f, fit.alpha_c].map(word).join(", ")),
        Fact::new("solver", &format!("{}, tolerance {:e}", solver.method.name(), solver.tolerance)),
    ]);
}

/// Describes the number of surfaces per point.
fn surfaces(statistics: &StatisticsConfig) -> String {
    let StatisticsConfig { realisations, nested, target, surfaces, seed, .. } = statistics;
    let number = match (surfaces.iter().min(), surfaces.iter().max()) {
        (Some(least), Some(most)) => format!("{least} to {most} at each point"),
        _ if *nested => format!("{realisations} on the largest grid, up to 64 times as many on smaller ones"),
        _ => format!("{realisations} at each point"),
    };
    let aim = if *target > 0.0 { format!(", for a statistical error of {} %", 100.0 * target) } else { String::new() };
    format!("{number}{aim}, first seed {seed}")
}

/// Describes the parts of the body below its top layer.
fn others(body: &BodyConfig) -> String {
    let mut parts = String::new();
    for [young, poisson, height] in &body.layers {
        parts += &format!("; a layer of {height} cell lengths, E = {young}, ν = {poisson}");
    }
    match (body.base, body.base_young, body.base_poisson) {
        (BaseKind::HalfSpace, Some(young), Some(poisson)) => {
            parts += &format!("; on a half-space, E = {young}, ν = {poisson}");
        }
        (BaseKind::Bonded, ..) => {}
        (base, ..) => parts += &format!("; {}", base.meaning()),
    }
    match body.second_body[..] {
        [young, poisson] => parts += &format!("; second body: half-space, E = {young}, ν = {poisson}"),
        [young, poisson, height] => {
            parts += &format!("; second body: slab of {height} cell lengths, E = {young}, ν = {poisson}");
        }
        _ => {}
    }
    parts
}

/// Draws the figures from the runs of the file. `stored` is the result in the file.
fn drawn(
    page: &mut Page,
    reader: &Reader,
    config: Config,
    stored: Option<f64>,
    session: &Session,
) -> Result<(), Failure> {
    let rows = reader.shape("/runs/kappa")?.first().copied().unwrap_or(0);
    let plan = Plan::new(config)?;
    if plan.runs.len() * plan.config.loads.p_star.len() != rows {
        return Err(Failure::refused(format!("/runs has {rows} rows, another number than its configuration")));
    }
    let runs = runs(reader, &plan, &mut Comparison::default())?;
    if session.is_interrupted() {
        return Err(Failure::interrupted("interrupted"));
    }
    let analysis = Analysis::new(&plan, &runs)?;
    let now = analysis.result().fit.kappa_tfc.value;
    if stored.is_some_and(|stored| (stored - now).abs() > 1e-9 * now.abs()) {
        page.remarks.push(format!(
            "the fit of this version, which the figures show, gives κ_TFC = {now:.4}, another number than the file"
        ));
    }
    let chart = figures::extrapolation(&plan.config, &analysis);
    let caption = html! {
        "κ against one refinement, less the fitted terms of the other two; line: the fit. Filled: counted points, \
         hollow: perimeter "
        "corrected. Band: " (kappa("TFC")) " with its total interval."
    };
    page.chart(&chart, "κ against a refinement", &caption);
    let caption = html! { "Contact area against the reduced pressure: the finest grid, and the limit." };
    let example = example(reader, &plan, false, &mut Comparison::default())?;
    let study = Study { plan, runs, analysis, example };
    let Study { plan, analysis, example, .. } = &study;
    if let Some(chart) = figures::protocol(&study) {
        let caption =
            html! { "κ along one axis for cells about the reference; broken lines: power laws through each of them." };
        page.chart(&chart, "κ along one axis", &caption);
    }
    if let Some(chart) = figures::area(plan, analysis) {
        page.chart(&chart, "contact area against pressure", &caption);
    }
    let modulus = plan.config.body()?.contact_modulus();
    let values: Vec<f64> = example.pressure.iter().map(|p| p / modulus).collect();
    let grid = &example.point.grid;
    let caption = html! {
        "An example: contact pressure over " i { "E" } "*, seed " (example.seed) ", H = " (example.point.hurst) "."
    };
    page.field(
        &pressure(grid, &values, "pressure *p*/*E*\\*", "cell length"),
        "contact pressure of an example",
        &caption,
    );
    let heights: Vec<f64> = example.heights.iter().copied().collect();
    let caption = html! { "The surface of the example, peaks towards the body." };
    page.field(&field(grid, &heights, "height / cell length", "cell length"), "heights of an example", &caption);
    Ok(())
}
