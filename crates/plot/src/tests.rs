use base64::Engine;

use super::*;

/// Returns a chart with all features: levels, bands, all marks, a shared ordinate, a legend.
fn everything() -> Chart {
    let panel = |title: &str, axis: &str| Panel {
        title: title.into(),
        x: Axis::linear(&format!("*ε*_{axis}^{{1.00}}")),
        y: Axis::linear("*κ* = *a*_r *E*\\* *ḡ* / *p*"),
        levels: vec![Level::line(2.507, "√(2π)"), Level::line(1.596, "√(8/π)"), Level::band([2.1, 2.2], "*κ*_{TFC}")],
        series: vec![
            Series::line("", 0, [(0.0, 2.15), (0.5, 2.9)]),
            Series::points(
                "*H* = 0.8",
                0,
                vec![Point::with_error(0.5, 2.91, 0.05), Point::with_error(0.25, 2.52, 0.04)],
            ),
            Series {
                mark: Mark::HollowPoints,
                ..Series::points("limit", 0, vec![Point::within(0.0, 2.15, [2.1, 2.2])])
            },
            Series { mark: Mark::Dashes, ..Series::line("a < b & \"c\"", 1, [(0.0, 2.0), (0.5, 2.1)]) },
            Series { mark: Mark::JoinedPoints, ..Series::points("joined", 2, vec![Point::new(0.1, 1.8)]) },
        ],
    };
    Chart::new(vec![panel("(a) thermodynamic", "t"), panel("(b) fractal", "f"), panel("(c) continuum", "c")])
}

fn residuals() -> Chart {
    let decay = (0..300).map(|i| (f64::from(i), 0.5 * (-0.06 * f64::from(i)).exp()));
    let panel = Panel {
        x: Axis::linear("transform pairs"),
        y: Axis::log("residual"),
        series: vec![Series::line("projected CG", 0, decay)],
        levels: vec![Level::line(1e-8, "tolerance")],
        ..Panel::default()
    };
    Chart::new(vec![panel])
}

/// Returns bumps on a plane, zero between them.
fn bumps(nx: usize, ny: usize) -> Vec<f64> {
    let wave = |i: usize, n: usize| (std::f64::consts::TAU * 3.0 * i as f64 / n as f64).sin();
    (0..nx * ny).map(|k| (wave(k / ny, nx) * wave(k % ny, ny) - 0.3).max(0.0)).collect()
}

fn pressure_map<'a>(values: &'a [f64], shape: [usize; 2]) -> Map<'a> {
    let below = Some(Below::pale(0.0, "no contact"));
    Map { below, ..Map::new(values, shape, [2.0, 1.0], "pressure *p* / *E*\\*") }
}

/// Decodes a PNG into width, height and pixels.
fn decode(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width, info.height, pixels)
}

/// Returns the text of each `<text>` element of an SVG in order; panics if the SVG is not well-formed XML.
fn words(svg: &str) -> Vec<String> {
    let document = resvg::usvg::roxmltree::Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.descendants().filter_map(|n| if n.is_text() { n.text() } else { None }).collect()).collect()
}

#[test]
fn figures_are_well_formed_and_have_their_words() {
    let words_of = words(&everything().svg().unwrap());
    let expected = [
        "(a) thermodynamic",
        "(b) fractal",
        "(c) continuum",
        "εt1.00",
        "εf1.00",
        "εc1.00",
        "κ = ar E* ḡ / p",
        "√(2π)",
        "↓ √(8/π) = 1.596",
        "κTFC",
        "H = 0.8",
        "limit",
        "a < b & \"c\"",
        "joined",
        "2.0",
        "2.5",
    ];
    for word in expected {
        assert!(words_of.iter().any(|found| found == word), "{word} is not among {words_of:?}");
    }
    let count = |word: &str| words_of.iter().filter(|found| *found == word).count();
    assert_eq!(
        [count("κ = ar E* ḡ / p"), count("√(2π)"), count("limit"), count("2.5")],
        [1; 4],
        "shared, not repeated"
    );

    let separate = Chart { share_y: false, ..everything() };
    let words_of = words(&separate.svg().unwrap());
    let count = |word: &str| words_of.iter().filter(|found| *found == word).count();
    assert_eq!([count("√(2π)"), count("√(8/π)"), count("↓ √(8/π) = 1.596")], [3, 0, 1]);

    let words_of = words(&residuals().svg().unwrap());
    for word in ["10−8", "10−2", "tolerance", "projected CG", "transform pairs"] {
        assert!(words_of.iter().any(|found| found == word), "{word} is not among {words_of:?}");
    }
    let field = bumps(64, 32);
    let words_of = words(&pressure_map(&field, [64, 32]).svg().unwrap());
    for word in ["no contact", "pressure p / E*", "x", "y", "0.0"] {
        assert!(words_of.iter().any(|found| found == word), "{word} is not among {words_of:?}");
    }
}

#[test]
fn images_have_300_dots_per_inch_and_ink() {
    for (chart, width) in [(everything(), TWO_COLUMNS), (residuals(), COLUMN)] {
        let (columns, rows, pixels) = decode(&chart.png().unwrap());
        assert_eq!(columns, (width / 72.0 * 300.0).round() as u32);
        assert!(rows > columns / 4 && rows < columns);
        let dark = pixels.chunks_exact(3).filter(|p| p.iter().all(|&c| c < 100)).count() as f64;
        let share = dark / f64::from(columns * rows);
        assert!((0.003..0.1).contains(&share), "axes and words cover {share}");
        // The edge is blank: neither text nor lines are cut off.
        let edge = |i: usize| {
            let (x, y) = (i as u32 % columns, i as u32 / columns);
            x < 3 || y < 3 || x + 3 >= columns || y + 3 >= rows
        };
        assert!(pixels.chunks_exact(3).enumerate().all(|(i, p)| !edge(i) || p == [255, 255, 255]));
    }
    let bytes = residuals().png().unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    assert_eq!(reader.info().pixel_dims.unwrap().xppu, 11811);
}

#[test]
fn words_are_drawn_without_system_fonts() {
    let blank = Chart { panels: vec![Panel { x: Axis::linear(""), ..residuals().panels.remove(0) }], ..residuals() };
    let ink = |chart: &Chart| decode(&chart.png().unwrap()).2.chunks_exact(3).filter(|p| p[0] < 100).count();
    assert!(ink(&residuals()) > ink(&blank) + 500, "the label of the abscissa is drawn");
}

#[test]
fn equal_input_gives_equal_bytes() {
    assert_eq!(everything().svg().unwrap(), everything().svg().unwrap());
    assert!(everything().png().unwrap() == everything().png().unwrap());
    let field = bumps(100, 50);
    let map = pressure_map(&field, [100, 50]);
    assert!(map.png().unwrap() == map.png().unwrap() && map.svg().unwrap() == map.svg().unwrap());
}

#[test]
fn files_are_written_under_both_names() {
    let folder = tempfile::tempdir().unwrap();
    let [svg, png] = everything().save(&folder.path().join("kappa.v1")).unwrap();
    assert_eq!(
        (svg.file_name().unwrap().to_str(), png.file_name().unwrap().to_str()),
        (Some("kappa.v1.svg"), Some("kappa.v1.png"))
    );
    assert_eq!(std::fs::read_to_string(svg).unwrap(), everything().svg().unwrap());
    assert_eq!(&std::fs::read(png).unwrap()[1..4], b"PNG");
    let line = residuals().save(&folder.path().join("none/kappa")).unwrap_err().to_string();
    assert!(line.starts_with("cannot write ") && line.contains("none/kappa.svg"), "{line}");
}

#[test]
fn large_maps_stay_small() {
    let (nx, ny) = (2048, 4096);
    let field = bumps(nx, ny);
    let map = pressure_map(&field, [nx, ny]);
    assert!(map.png().unwrap().len() < 1_000_000);
    let svg = map.svg().unwrap();
    assert!(svg.len() < 1_000_000 && svg.matches("<image").count() == 1 && svg.matches("<rect").count() < 10);
}

#[test]
fn maps_lie_the_right_way_round() {
    // One contact point near the corner x = 0, large y: top left of the picture.
    let (nx, ny) = (8, 4);
    let mut field = vec![0.0; nx * ny];
    field[3] = 1.0;
    let map = Map { range: Some([0.0, 1.0]), ..pressure_map(&field, [nx, ny]) };
    let drawing = map::draw(&map).unwrap();
    let picture = &drawing.pictures[0];
    assert_eq!((picture.columns, picture.rows), (8, 4));
    let mut colours = picture.colours();
    assert_eq!(colours.next(), Some(colour::sequential(1.0)));
    assert!(colours.all(|pixel| pixel == colour::PALE));
    // The rendered page has the same colours.
    let (columns, _, pixels) = decode(&map.png().unwrap());
    let scale = 300.0 / 72.0;
    let [left, top, width, height] = picture.frame;
    let at = |fx: f64, fy: f64| {
        let (x, y) = ((scale * (left + fx * width)) as u32, (scale * (top + fy * height)) as u32);
        let i = 3 * (y * columns + x) as usize;
        [pixels[i], pixels[i + 1], pixels[i + 2]]
    };
    assert_eq!([at(1.0 / 16.0, 1.0 / 8.0), at(3.0 / 16.0, 1.0 / 8.0)], [colour::sequential(1.0), colour::PALE]);
    assert_eq!(at(1.0 / 16.0, 7.0 / 8.0), colour::PALE);
    approx::assert_relative_eq!(width / height, 2.0, max_relative = 1e-9);
}

/// A flat section in true proportions would leave no room for its labels.
#[test]
fn a_flat_map_is_high_enough_for_its_labels() {
    let field = bumps(64, 4);
    let flat = Map { size: [100.0, 1.0], y: "height above the lowest level".into(), ..pressure_map(&field, [64, 4]) };
    let drawing = map::draw(&flat).unwrap();
    let [_, _, width, height] = drawing.pictures[0].frame;
    let label = text::Text::new(&flat.y, frame::LABEL).width();
    assert!(height >= label && height < width, "{height} {label} {width}");
}

/// The picture in an SVG has the colours of the map, with one byte per pixel, or three if blocks of points mix colours.
#[test]
fn the_picture_of_an_svg_has_the_colours_of_the_map() {
    for (n, kind) in [(64, png::ColorType::Indexed), (2048, png::ColorType::Rgb)] {
        let field = bumps(n, n);
        let map = pressure_map(&field, [n, n]);
        let svg = map.svg().unwrap();
        let data = svg.split_once(";base64,").unwrap().1.split('"').next().unwrap();
        let bytes = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().color_type, kind);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert!(map::draw(&map).unwrap().pictures[0].colours().flatten().eq(pixels));
    }
}

#[test]
fn blocks_of_points_become_one_pixel_of_their_mean_and_share() {
    let n = 2048; // two by two points per pixel
    let mut field = vec![0.0; n * n];
    (field[0], field[1]) = (0.25, 0.75); // half of the block at the lower left
    let map = Map { range: Some([0.0, 1.0]), ..pressure_map(&field, [n, n]) };
    let picture = map::draw(&map).unwrap().pictures.remove(0);
    assert_eq!((picture.columns, picture.rows), (1024, 1024));
    let expected = colour::mix(colour::sequential(0.5), colour::PALE, 0.5);
    assert_eq!(picture.colours().nth(1023 * 1024), Some(expected));
    assert_eq!(picture.colours().filter(|&pixel| pixel != colour::PALE).count(), 1);
}

#[test]
fn a_few_singular_values_do_not_set_the_colour_range() {
    let mut field: Vec<f64> = (0..10_000).map(|i| f64::from(i) / 10_000.0).collect();
    let plain = pressure_map(&field, [100, 100]).svg().unwrap();
    field[17] = 1e6;
    let spiked = pressure_map(&field, [100, 100]).svg().unwrap();
    let highest = |svg: &str| words(svg).iter().filter_map(|word| word.parse::<f64>().ok()).fold(0.0, f64::max);
    assert!(highest(&spiked) <= 2.0 && highest(&plain) <= 2.0);
    assert!(spiked.matches("<path").count() > plain.matches("<path").count(), "the bar has a point");
    // Without a class below, outliers are clipped at the lower end as well.
    let heights: Vec<f64> = (0..10_000).map(|i| f64::from(i) / 10_000.0).collect();
    let map = |heights: &[f64]| Map::new(heights, [100, 100], [2.0, 1.0], "height").svg().unwrap();
    let pitted: Vec<f64> = heights.iter().map(|h| if *h == 0.5 { -1e6 } else { *h }).collect();
    assert!(map(&pitted).matches("<path").count() > map(&heights).matches("<path").count());
    assert!(!map(&pitted).contains("×10"), "the labels are those of the other heights");
}

#[test]
fn invalid_input_is_refused() {
    let with = |change: &dyn Fn(&mut Panel)| {
        let mut chart = residuals();
        change(&mut chart.panels[0]);
        chart.svg().unwrap_err().to_string()
    };
    let line = with(&|panel| panel.series[0].points[3].y = f64::NAN);
    assert_eq!(line, "point 3 of series \"projected CG\" is NaN; it must be finite");
    let line = with(&|panel| panel.series[0].points[3].y = 0.0);
    assert!(line.ends_with("is 0; it must be above zero on a logarithmic axis"), "{line}");
    assert!(with(&|panel| panel.levels[0].range = [f64::INFINITY; 2]).contains("reference \"tolerance\""));
    assert!(with(&|panel| panel.series[0].points[0].range = Some([f64::NAN, 1.0])).contains("NaN"));
    assert_eq!(with(&|panel| panel.series.clear()), "nothing to plot: a panel has no points");
    assert!(with(&|panel| panel.x.range = Some([1.0, 1.0])).starts_with("the range of an axis is 1.0 to 1.0;"));
    assert!(matches!(Chart::new(vec![]).png(), Err(PlotError::Empty { .. })));

    let field = bumps(4, 4);
    assert!(matches!(pressure_map(&field, [4, 5]).svg(), Err(PlotError::Shape { found: 16, shape: [4, 5] })));
    assert!(matches!(pressure_map(&field[..4], [4, 1]).svg(), Err(PlotError::Shape { .. })));
    assert!(matches!(pressure_map(&field, [usize::MAX, 2]).svg(), Err(PlotError::Shape { .. })));
    let mut broken = field.clone();
    broken[6] = f64::NAN;
    let line = pressure_map(&broken, [4, 4]).svg().unwrap_err().to_string();
    assert!(line.contains("the map at [1, 2]"), "{line}");
    let map = Map { range: Some([1.0, 0.0]), ..pressure_map(&field, [4, 4]) };
    assert!(matches!(map.svg(), Err(PlotError::BadRange { .. })));
    let line = Map { size: [0.0, 1.0], ..pressure_map(&field, [4, 4]) }.svg().unwrap_err();
    assert!(matches!(line, PlotError::BadRange { .. }));
}

#[test]
fn degenerate_data_are_drawn() {
    // One point, equal points, a constant field, no contact, error bars beyond zero on a logarithmic axis.
    let one = |y: Axis, points: Vec<Point>| {
        Chart::new(vec![Panel {
            x: Axis::linear("x"),
            y,
            series: vec![Series::points("", 0, points)],
            ..Panel::default()
        }])
    };
    one(Axis::linear("y"), vec![Point::new(0.0, 0.0)]).png().unwrap();
    one(Axis::linear("y"), vec![Point::new(1e300, -1e300), Point::new(1e300, -1e300)]).png().unwrap();
    let below_zero = one(Axis::log("y"), vec![Point::with_error(1.0, 1e-3, 2e-3), Point::new(2.0, 1.0)]);
    assert!(!below_zero.svg().unwrap().contains("NaN"));
    for value in [0.0, -2.5] {
        let field = vec![value; 36];
        Map::new(&field, [6, 6], [1.0, 1.0], "height").png().unwrap();
        pressure_map(&field, [6, 6]).png().unwrap();
    }
}

/// Numbers of any size are drawn or refused in words, without a panic and without NaN or infinite coordinates.
#[test]
fn numbers_of_any_size_are_drawn_or_refused() {
    let extremes = [
        0.0,
        1.0,
        1.0 + f64::EPSILON,
        -1.0,
        1e15,
        1e20 * (1.0 + 1e-13),
        1e20,
        1e-15,
        -1e-100,
        1e300,
        -1e300,
        1e307,
        1e308,
        -1e308,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        5e-324,
        -5e-324,
        f64::INFINITY,
        f64::NAN,
    ];
    let (mut drawn, mut refused) = (0, 0);
    let mut judge = |outcome: Result<String, PlotError>, what: &dyn Fn() -> String| match outcome {
        Ok(svg) => {
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", what());
            drawn += 1;
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n') && error.to_string().len() < 1000, "{error}");
            refused += 1;
        }
    };
    for a in extremes {
        for b in extremes {
            for (x, y) in [
                (Axis::linear("x"), Axis::linear("y")),
                (Axis::log("x"), Axis::log("y")),
                (Axis::linear("x").over([a, b]), Axis::log("y").over([b, a])),
            ] {
                let panel = Panel {
                    x,
                    y,
                    series: vec![
                        Series::points("p", 0, vec![Point::within(a, b, [b, a]), Point::new(b, a)]),
                        Series { mark: Mark::Filled(Side::Zero), ..Series::line("l", 1, [(1.0, a), (2.0, b)]) },
                    ],
                    levels: vec![Level::band([a, b], "band")],
                    ..Panel::default()
                };
                let chart = Chart::new(vec![panel.clone(), Panel { title: "b".into(), ..panel.clone() }]);
                judge(chart.svg(), &|| format!("chart {a:e} {b:e}"));
                judge(Chart::stacked(vec![panel.clone(), panel]).svg(), &|| format!("stacked {a:e} {b:e}"));
            }
            let values = [a, b, a, 1.0, 0.5, b];
            for scale in [Scale::Linear, Scale::Log] {
                let map = Map { scale, ..Map::new(&values, [3, 2], [1.0, 1.0], "map") };
                judge(map.svg(), &|| format!("map {a:e} {b:e}"));
                let below = Map { below: Some(Below::pale(a, "none")), range: Some([a, b]), ..map.clone() };
                judge(below.svg(), &|| format!("map of a range {a:e} {b:e}"));
                judge(Map { size: [a, b], ..map }.svg(), &|| format!("map of a size {a:e} {b:e}"));
            }
        }
    }
    assert!(drawn > 500 && refused > 500, "{drawn} {refused}");
}

/// Two figures in one page must not share ids; labels stay unchanged.
#[test]
fn elements_of_a_page_have_ids_of_their_own() {
    let values = bumps(8, 6);
    let map = pressure_map(&values, [8, 6]);
    let both = [map.element("one", "bumps & <dips>").unwrap(), everything().element("two", "url(#panel0)").unwrap()];
    for (element, name) in both.iter().zip(["one", "two"]) {
        assert!(element.starts_with("<svg ") && element.contains(" role=\"img\">"));
        for id in element.split(" id=\"").skip(1) {
            let id = id.split('"').next().unwrap();
            assert!(id.starts_with(name), "{id}");
            assert!(element.contains(&format!("\"url(#{id})\"")), "{id} is used");
        }
        assert_eq!(element.matches("\"url(#").count(), element.matches(&format!("\"url(#{name}-")).count());
    }
    assert!(
        both[0].contains("<title>bumps &amp; &lt;dips&gt;</title>") && both[1].contains("<title>url(#panel0)</title>")
    );
}

/// A map without a colour bar has no scale, but the class has its swatch.
#[test]
fn a_map_without_a_bar_has_its_label_and_its_class() {
    let values: Vec<f64> = (0..16).map(|i| f64::from(i % 5)).collect();
    let below = Some(Below::pale(0.0, "no contact"));
    let with = Map { below, ..Map::new(&values, [4, 4], [1.0, 1.0], "patches") };
    let without = Map { bar: false, ..with.clone() };
    let [with, without] = [with, without].map(|map| map.svg().unwrap());
    assert_eq!([&with, &without].map(|svg| svg.matches("linearGradient id").count()), [1, 0]);
    assert_eq!(with.matches("<rect").count(), without.matches("<rect").count() + 1);
    let width = |svg: &str| svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()).map(str::to_owned);
    assert_eq!(width(&with), width(&without));
}

#[test]
fn maps_side_by_side_keep_their_bars_apart() {
    let values = bumps(16, 16);
    let map = Map::new(&values, [16, 16], [1.0, 1.0], "bumps");
    let maps = Maps(vec![map.clone(), Map { range: Some([0.0, 2.0]), ..map.clone() }]);
    let svg = maps.svg().unwrap();
    assert_eq!((svg.matches("<image").count(), svg.matches("id=\"part1-bar\"").count()), (2, 1));
    let [(width, height, _), (both, same, _)] = [map.png().unwrap(), maps.png().unwrap()].map(|bytes| decode(&bytes));
    assert_eq!((2 * width, height), (both, same));
    assert!(matches!(Maps(vec![]).svg(), Err(PlotError::Empty { .. })));
}

#[test]
fn a_long_map_keeps_a_pixel_a_point() {
    let (nx, ny) = (4096, 64);
    let field: Vec<f64> = (0..nx * ny).map(|k| ((k / ny + k % ny) % 2) as f64).collect();
    let map = Map { width: TWO_COLUMNS, ..Map::new(&field, [nx, ny], [64.0, 1.0], "squares") };
    let drawing = map::draw(&map).unwrap();
    let picture = &drawing.pictures[0];
    assert_eq!((picture.columns, picture.rows), (nx, ny));
    let [left, top, width, height] = picture.frame;
    let (columns, _, pixels) = decode(&map.png().unwrap());
    let scale = nx as f64 / width;
    assert_eq!(columns, (scale * drawing.width).round() as u32);
    let line = (scale * (top + (20.5 / ny as f64) * height)) as usize * columns as usize;
    // The dots of the axes cover the first and the last points.
    for i in 100..nx - 100 {
        let at = 3 * (line + (scale * left).round() as usize + i);
        let expected = colour::sequential(((i + ny - 1 - 20) % 2) as f64);
        assert_eq!(pixels[at..at + 3], expected, "{i}");
    }
    // A larger scan is divided into square blocks of points.
    let field = vec![1.0; 32768 * 64];
    let picture = map::draw(&Map::new(&field, [32768, 64], [512.0, 1.0], "")).unwrap().pictures.remove(0);
    assert!(picture.columns <= 8192 && picture.columns * picture.rows <= 1 << 20);
}

#[test]
fn logarithmic_colours_have_equal_factors() {
    let field = [1e-3, 1e-2, 1e-1, 1.0];
    let map = Map { scale: Scale::Log, ..Map::new(&field, [2, 2], [1.0, 1.0], "gap") };
    let picture = map::draw(&map).unwrap().pictures.remove(0);
    // The top row has y = 1.
    let expected = [85.0 / 254.0, 1.0, 0.0, 169.0 / 254.0].map(colour::sequential);
    assert!(picture.colours().eq(expected));
    let found = words(&map.svg().unwrap());
    assert!(found.iter().any(|word| word == "0.01") || found.iter().any(|word| word == "10−2"), "{found:?}");

    // A class below has its own colour and does not affect the range.
    let closed = [0.0, 1e-2, 1e-1, 1.0];
    let below = Some(Below { hue: Some(1), ..Below::pale(0.0, "contact") });
    let classed = Map { scale: Scale::Log, below, ..Map::new(&closed, [2, 2], [1.0, 1.0], "gap") };
    let picture = map::draw(&classed).unwrap().pictures.remove(0);
    let expected = [colour::sequential(0.0), colour::sequential(1.0), colour::hue(1), colour::sequential(0.5)];
    assert!(picture.colours().eq(expected));
    assert!(classed.svg().unwrap().contains(&colour::hex(colour::hue(1))));
    for value in [0.0, -1.0] {
        let field = [value, 1.0, 1.0, 1.0];
        let line = Map { scale: Scale::Log, ..Map::new(&field, [2, 2], [1.0, 1.0], "") }.svg().unwrap_err();
        assert!(matches!(line, PlotError::NotPositive { found, .. } if found == value));
    }
    // All values in one class, and all values equal.
    for value in [0.0, 3.0] {
        let below = Some(Below::pale(0.0, "contact"));
        Map { scale: Scale::Log, below, ..Map::new(&[value; 4], [2, 2], [1.0, 1.0], "") }.png().unwrap();
    }
    // At most eight decades.
    let deep = [1e-20, 1e-20, 1e-20, 1.0];
    let svg = Map { scale: Scale::Log, ..Map::new(&deep, [2, 2], [1.0, 1.0], "") }.svg().unwrap();
    assert!(words(&svg).iter().any(|word| word == "10−8") && !words(&svg).iter().any(|word| word == "10−10"));
}

#[test]
fn two_signs_have_two_colours_and_zero_none() {
    let field = [-1.0, 0.0, 0.0, 1.0];
    let range = Some([-1.0, 1.0]);
    let map = Map { colours: Colours::Diverging, range, ..Map::new(&field, [2, 2], [1.0, 1.0], "traction") };
    let drawing = map::draw(&map).unwrap();
    let colours: Vec<_> = drawing.pictures[0].colours().collect();
    let [zero, repulsion, attraction, same] = colours[..] else { panic!() };
    assert_eq!(zero, same);
    assert!(zero.iter().all(|&c| c > 230), "{zero:?}");
    assert!(repulsion[2] > repulsion[0] && attraction[0] > attraction[2] && repulsion != attraction);
}

/// A map as flat as its bar leaves room for the bar label beside the coloured part.
#[test]
fn the_label_of_a_bar_with_points_is_not_cut_off() {
    let mut field = vec![0.5; 4096 * 4];
    (field[0], field[1], field[2]) = (1e-9, 0.0, 2.0);
    let below = Some(Below::pale(0.0, "contact"));
    let map = Map {
        below,
        range: Some([0.1, 1.0]),
        width: TWO_COLUMNS,
        ..Map::new(&field, [4096, 4], [1e3, 1.0], "a long label")
    };
    let (columns, _, pixels) = decode(&map.png().unwrap());
    let edge = 3 * 3 * columns as usize;
    assert!(pixels[..edge].iter().all(|&c| c == 255), "the upper edge is blank");
}

#[test]
fn stacked_panels_have_one_abscissa() {
    let filled =
        |side, hue, pairs: [(f64, f64); 2]| Series { mark: Mark::Filled(side), ..Series::line("area", hue, pairs) };
    let panel =
        |label: &str, series| Panel { x: Axis::linear("place"), y: Axis::linear(label), series, ..Panel::default() };
    let upper = panel(
        "height",
        vec![filled(Side::Top, 6, [(0.0, 1.0), (2.0, 3.0)]), filled(Side::Bottom, 5, [(0.0, 0.0), (2.0, 0.5)])],
    );
    let bold = Series { mark: Mark::Bold, ..Series::line("bold", 1, [(0.5, 7.0), (1.0, 7.0)]) };
    let lower = panel("pressure", vec![filled(Side::Zero, 0, [(1.0, 5.0), (4.0, 7.0)]), bold]);
    let chart = Chart::stacked(vec![upper, lower]);
    let svg = chart.svg().unwrap();
    let found = words(&svg);
    let count = |word: &str| found.iter().filter(|found| *found == word).count();
    assert_eq!([count("place"), count("height"), count("pressure"), count("area"), count("bold")], [1; 5], "{found:?}");
    // Both panels have the same left edge and width. Zero is in the range of an area that is filled from zero.
    let boxes: Vec<&str> = svg.split("<clipPath").skip(1).collect();
    let side = |panel: usize, name: &str| -> f64 {
        boxes[panel].split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    assert_eq!((boxes.len(), side(0, "x"), side(0, "width")), (2, side(1, "x"), side(1, "width")));
    assert!(side(1, "y") > side(0, "y") + side(0, "height") && side(0, "height") == 2.0 * side(1, "height"));
    assert!(found.iter().any(|word| word == "0"), "{found:?}");
    // The area up to the upper edge ends there.
    let top = text::number(side(0, "y"));
    assert!(svg.contains(&format!(" {top}Z\" fill=\"{}\"", colour::hex(colour::hue(6)))), "{svg}");
    let drawn = decode(&chart.png().unwrap());
    assert_eq!(drawn.0, (TWO_COLUMNS / 72.0 * 300.0).round() as u32);
    assert!(matches!(Chart::stacked(vec![]).svg(), Err(PlotError::Empty { .. })));
}
