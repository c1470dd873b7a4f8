//! Text tables and grids, written at random in every dialect and read back, and single tables of programs. A table is
//! read as intended, or refused with advice on what to write.

use std::fmt::Write;

use gfmd_topography::Topography;
use ndarray::Array2;

fn parse(text: &str) -> Result<Topography, String> {
    Topography::from_bytes("scan", text.into(), None).map_err(|error| error.reason)
}

fn read(text: &str) -> Topography {
    parse(text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

fn refusal(text: &str) -> String {
    match parse(text) {
        Ok(map) => panic!("{:?} heights {} from\n{text}", map.heights.dim(), map.heights),
        Err(reason) => reason,
    }
}

/// Computes the root mean square of the defined heights about their mean.
fn rms(map: &Topography) -> f64 {
    let defined: Vec<f64> = map.heights.iter().copied().filter(|height| height.is_finite()).collect();
    let mean = defined.iter().sum::<f64>() / defined.len() as f64;
    (defined.iter().map(|height| (height - mean).powi(2)).sum::<f64>() / defined.len() as f64).sqrt()
}

/// Pseudo-random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a whole number in the range.
    fn of(&mut self, range: std::ops::Range<usize>) -> usize {
        range.start + (self.next() % (range.end - range.start) as u64) as usize
    }

    fn yes(&mut self) -> bool {
        self.next().is_multiple_of(2)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.of(0..of.len())]
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.of(0..last + 1));
        }
    }
}

/// Returns the number of random tables of a kind, which is larger if `GFMD_LONG` is set.
fn count() -> usize {
    if std::env::var_os("GFMD_LONG").is_some() { 20_000 } else { 400 }
}

/// Words for a point without a height.
const MISSING: [&str; 14] =
    ["nan", "NaN", "***", "---", "N/A", "#N/A", "1.#QNAN", "-1.#IND", "null", "None", "?", "OVER", "BAD", "NODATA"];

/// Notation of numbers.
#[derive(Clone, Copy, Debug)]
struct Style {
    separator: &'static str,
    comma: bool,
    end: &'static str,
    missing: &'static str,
}

impl Style {
    fn any(random: &mut Random) -> Self {
        let separator = random.one(&[" ", "\t", ",", ";", ", ", "  ", "; "]);
        let comma = !separator.starts_with(',') && random.of(0..3) == 0;
        Self { separator, comma, end: random.one(&["\n", "\r\n", "\r"]), missing: random.one(&MISSING) }
    }

    fn number(self, value: f64, decimals: usize) -> String {
        match value.is_nan() {
            true => self.missing.into(),
            false if self.comma => format!("{value:.decimals$}").replace('.', ","),
            false => format!("{value:.decimals$}"),
        }
    }

    fn line(self, words: &[String]) -> String {
        words.join(self.separator) + self.end
    }
}

/// Returns heights with three decimals, some of them undefined if `holes`.
fn heights(random: &mut Random, [nx, ny]: [usize; 2], holes: bool) -> Array2<f64> {
    let hole = if holes { random.of(5..20) } else { usize::MAX };
    Array2::from_shape_simple_fn((nx, ny), || {
        let height = random.of(0..8000) as f64 / 1e3 - 4.0;
        let height = format!("{height:.3}").parse().unwrap();
        if hole < usize::MAX && random.of(0..hole) == 0 { f64::NAN } else { height }
    })
}

/// Checks that a map has these heights, times a factor, and these lengths.
fn check(found: &Topography, expected: &Array2<f64>, factor: f64, lengths: Option<[f64; 2]>, text: &str) {
    assert_eq!(found.heights.dim(), expected.dim(), "{text}");
    for ((i, j), expected) in expected.indexed_iter() {
        let (height, expected) = (found.heights[[i, j]], expected * factor);
        let close = (height - expected).abs() <= 1e-14 * expected.abs().max(1e-3 * factor);
        assert!(close || height.is_nan() && expected.is_nan(), "[{i}, {j}]: {height} for {expected} in\n{text}");
    }
    match (found.lengths, lengths) {
        (Some(found), Some(lengths)) => {
            for (found, length) in found.into_iter().zip(lengths) {
                assert!((found / length - 1.0).abs() < 1e-9, "{found} for {length} in\n{text}");
            }
        }
        (found, lengths) => assert_eq!(found, lengths, "{text}"),
    }
}

/// Returns true if a reason gives advice.
fn advises(reason: &str) -> bool {
    !reason.contains('\n') && reason.contains("must")
}

#[test]
fn lists_of_points_are_read_back_in_every_dialect() {
    let mut random = Random(1);
    let (mut read, mut refused) = (0, Vec::new());
    for _ in 0..count() {
        let style = Style::any(&mut random);
        let n = [random.of(2..9), random.of(3..9)];
        let decimals = random.of(0..4);
        let unit = 10_f64.powi(-i32::try_from(decimals).unwrap());
        let [step, start] = [(); 2].map(|()| [random.of(1..40) as f64, random.of(1..40) as f64]);
        let at = |axis: usize, k: usize| (start[axis] - 20.0 + k as f64 * step[axis]) * unit;
        let holes = random.of(0..3) == 0;
        let mut map = heights(&mut random, n, holes);
        // A line or column without a point does not appear in a list.
        map.iter_mut().take(1).for_each(|height| *height = 0.125);
        let [index, extra] = [random.of(0..4) == 0, random.of(0..4) == 0];
        let dropped = holes && random.yes() && !index && !extra;
        let mut points: Vec<[usize; 2]> = match random.of(0..4) {
            0 => (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| [i, j])).collect(),
            1 => (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| [i, j])).collect(),
            2 => {
                (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| [if j % 2 == 0 { i } else { n[0] - 1 - i }, j])).collect()
            }
            _ => {
                let mut points: Vec<_> = (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| [i, j])).collect();
                random.shuffle(&mut points);
                points
            }
        };
        if random.yes() {
            points.iter_mut().for_each(|point| point[0] = n[0] - 1 - point[0]);
        }
        if random.of(0..3) == 0 {
            points.iter_mut().for_each(|point| point[1] = n[1] - 1 - point[1]);
        }
        if dropped {
            // At least one point of each line and column remains.
            points.retain(|&[i, j]| i == 0 || j == 0 || !map[[i, j]].is_nan());
        }
        let head = random.of(0..4);
        let mut text = String::new();
        let names = |units: [&str; 3]| {
            let mut names: Vec<String> = Vec::new();
            names.extend(index.then(|| "node".to_owned()));
            names.extend(["x", "y", "z"].iter().zip(units).map(|(name, unit)| format!("{name}{unit}")));
            names.extend(extra.then(|| "intensity".to_owned()));
            style.line(&names)
        };
        let (factor, scale) = match head {
            0 => (1.0, 1.0),
            1 => {
                text += &names([""; 3]);
                (1.0, 1.0)
            }
            2 => {
                text += &names([" [um]", " [um]", " [nm]"]);
                (1e-3, 1.0)
            }
            _ => {
                text += &format!("# made by a program{}", style.end);
                text += &names(["(mm)", "(mm)", "(um)"]);
                (1e-3, 1.0)
            }
        };
        for (number, &[i, j]) in points.iter().enumerate() {
            let mut words: Vec<String> = Vec::new();
            words.extend(index.then(|| (number + 1).to_string()));
            words.extend([at(0, i), at(1, j)].map(|value| style.number(value, decimals)));
            words.push(style.number(map[[i, j]], 3));
            words.extend(extra.then(|| random.of(0..100).to_string()));
            text += &style.line(&words);
        }
        let lengths = [0, 1].map(|axis| step[axis] * unit * n[axis] as f64 * scale);
        match parse(&text) {
            Ok(found) => {
                check(&found, &map, factor, Some(lengths), &text);
                read += 1;
            }
            Err(reason) => {
                assert!(advises(&reason), "{reason} in\n{text}");
                refused.push((reason, text));
            }
        }
    }
    // Lists with gaps and a spacing of one unit of the last digit may be rounded.
    assert!(read > 9 * refused.len(), "{read} {refused:?}");
}

#[test]
fn profiles_are_read_back_in_every_dialect() {
    let mut random = Random(2);
    for _ in 0..count() {
        let style = Style::any(&mut random);
        let n = random.of(4..60);
        let holes = random.of(0..4) == 0;
        let map = heights(&mut random, [n, 1], holes);
        let [step, start] = [random.of(1..400) as f64 / 1e3, random.of(0..400) as f64 / 1e3 - 0.2];
        let (head, factor) = random.one(&[
            ("", 1.0),
            ("# a profile", 1.0),
            ("x@z", 1.0),
            ("X (mm)@Z (um)", 1e-3),
            ("Lateral um@Raw nm", 1e-3),
            ("x[mm]@height[mm]", 1.0),
        ]);
        let mut text = String::new();
        if !head.is_empty() {
            text += &(head.replace('@', style.separator) + style.end);
        }
        let falls = random.yes();
        for k in 0..n {
            let k = if falls { n - 1 - k } else { k };
            text += &style.line(&[style.number(start + k as f64 * step, 3), style.number(map[[k, 0]], 3)]);
        }
        check(&read(&text), &map, factor, Some([n as f64 * step, 1.0]), &text);
    }
}

#[test]
fn rounded_coordinates_give_the_spacing_within_their_digits_or_are_refused() {
    let mut random = Random(3);
    let mut found = 0;
    for _ in 0..count() / 4 {
        let n = [random.of(8..20), random.of(8..20)];
        // Between 1.5 and 10 units of the last digit.
        let step = [(); 2].map(|()| random.of(1500..10_000) as f64 / 1e4);
        let map = heights(&mut random, n, false);
        let mut text = String::new();
        for ((j, i), _) in Array2::<f64>::zeros((n[1], n[0])).indexed_iter() {
            writeln!(text, "{:.1} {:.1} {:.3}", i as f64 * step[0], j as f64 * step[1], map[[i, j]]).unwrap();
        }
        let profile: String = (0..n[0]).map(|i| format!("{:.1};{:.3}\n", i as f64 * step[0], map[[i, 0]])).collect();
        let one = read(&profile);
        assert_eq!(one.heights.column(0), map.column(0));
        let along = one.lengths.unwrap()[0] / n[0] as f64;
        assert!((along - step[0]).abs() <= 0.1 / (n[0] - 1) as f64, "{along} {step:?}");
        match parse(&text) {
            Ok(surface) => {
                assert_eq!(surface.heights, map, "{text}");
                for axis in 0..2 {
                    let along = surface.lengths.unwrap()[axis] / n[axis] as f64;
                    assert!((along - step[axis]).abs() <= 0.1 / (n[axis] - 1) as f64, "{along} {step:?}");
                }
                found += 1;
            }
            Err(reason) => assert!(advises(&reason), "{reason}"),
        }
    }
    assert!(found > 9 * count() / 40, "{found}");
}

#[test]
fn matrices_are_read_back_in_every_dialect() {
    let mut random = Random(4);
    for _ in 0..count() {
        let style = Style::any(&mut random);
        let n = [random.of(5..12), random.of(4..12)];
        let holes = random.of(0..4) == 0;
        let map = heights(&mut random, n, holes);
        let quoted = style.separator.starts_with([',', ';']) && random.of(0..4) == 0;
        let word = |text: String| if quoted { format!("\"{text}\"") } else { text };
        let coordinate = |axis: usize, k: usize| format!("{:.1}", 0.5 * (axis + 1) as f64 * k as f64);
        let label = random.of(0..4);
        // Labels need a separator that leaves a corner empty, or a word in the corner.
        let label = if label == 1 && style.separator.starts_with(' ') { 2 } else { label };
        let plain = Style { comma: false, ..style };
        let mut text = String::new();
        let mut lengths = None;
        let head = match label {
            0 if random.yes() => {
                text += &format!("# Channel: Topo{0}# Width: 12 µm{0}# Height: 9 µm{0}# Value units: nm{0}", style.end);
                lengths = Some([12_000.0, 9_000.0]);
                None
            }
            0 => None,
            // Numbers of rows and columns, as written by pandas.
            1 => Some((String::new(), None)),
            _ => {
                lengths = Some([0.5 * n[0] as f64, n[1] as f64]);
                Some(("y\\x".to_owned(), Some(())))
            }
        };
        let named = |axis: usize, k: usize, by: Option<()>| match by {
            None => k.to_string(),
            Some(()) => {
                if style.comma {
                    coordinate(axis, k).replace('.', ",")
                } else {
                    coordinate(axis, k)
                }
            }
        };
        if let Some((corner, by)) = &head {
            let labels = (0..n[0]).map(|i| named(0, i, *by));
            text += &plain.line(&std::iter::once(corner.clone()).chain(labels).collect::<Vec<_>>());
        }
        for j in 0..n[1] {
            let mut words: Vec<String> = head.iter().map(|(_, by)| named(1, j, *by)).collect();
            words.extend((0..n[0]).map(|i| word(style.number(map[[i, j]], 3))));
            text += &style.line(&words);
        }
        check(&read(&text), &map, 1.0, lengths, &text);
        if label == 0 && lengths.is_none() {
            let mut wide = vec![0xff, 0xfe];
            wide.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
            let found = Topography::from_bytes("scan", wide, None).unwrap();
            check(&found, &map, 1.0, None, &text);
            // A column of row numbers without any label.
            if n[1] > 4 {
                let numbered: String = text
                    .split(style.end)
                    .enumerate()
                    .filter(|(_, line)| !line.is_empty())
                    .fold(String::new(), |all, (k, line)| all + &format!("{k}{}{line}{}", style.separator, style.end));
                let reason = refusal(&numbered);
                assert!(reason.contains("the first column rises") && advises(&reason), "{reason} in\n{numbered}");
            }
        }
    }
}

#[test]
fn grids_of_programs_are_read_back() {
    let mut random = Random(5);
    for _ in 0..count() {
        let n = [random.of(2..9), random.of(2..9)];
        let [nx, ny] = n;
        let map = heights(&mut random, n, true);
        let cell = [random.of(1..40) as f64 / 8.0, random.of(1..40) as f64 / 8.0];
        let lengths = [cell[0] * nx as f64, cell[1] * ny as f64];
        let end = random.one(&["\n", "\r\n"]);
        let value = |i: usize, j: usize, missing: &str| {
            let height = map[[i, j]];
            if height.is_nan() { missing.to_owned() } else { format!("{height:.3}") }
        };
        let rows = |top: bool, missing: &str, separator: &str| -> String {
            let line = |j: usize| (0..nx).map(|i| value(i, j, missing)).collect::<Vec<_>>().join(separator) + end;
            if top { (0..ny).rev().map(line).collect() } else { (0..ny).map(line).collect() }
        };
        // Esri.
        let missing = random.one(&["-9999", "-32768", "1e10"]);
        let mut keys =
            vec![format!("ncols {nx}"), format!("NROWS {ny}"), "xllcorner 5.5".into(), "yllcenter -1".into()];
        keys.extend(["dx", "DY"].iter().zip(cell).map(|(key, cell)| format!("{key} {cell}")));
        if missing != "-9999" || random.yes() {
            keys.push(format!("NODATA_value {missing}"));
        }
        // The first word identifies the format.
        random.shuffle(&mut keys[1..]);
        let text = keys.join(end) + end + &rows(true, missing, " ");
        check(&read(&text), &map, 1.0, Some(lengths), &text);
        // Surfer.
        let limits = [1.0, 1.0 + cell[0] * (nx - 1) as f64, -2.0, -2.0 + cell[1] * (ny - 1) as f64];
        let text = format!(
            "DSAA{end}{nx} {ny}{end}{} {}{end}{} {}{end}-4 4{end}{}",
            limits[0],
            limits[1],
            limits[2],
            limits[3],
            rows(false, "1.70141e+38", " ")
        );
        check(&read(&text), &map, 1.0, Some(lengths), &text);
        // Wyko, with lines along y.
        let [waves, aspect] = [random.yes(), true];
        let columns: String =
            (0..nx).map(|i| (0..ny).map(|j| value(i, j, "Bad")).collect::<Vec<_>>().join("\t") + end).collect();
        let mut text = format!("Wyko ASCII Data File Format 0\t{}\t1{end}", i32::from(!waves));
        write!(text, "X Size\t{nx}{end}Y Size\t{ny}{end}Block Name\tType\tLength\tValue{end}").unwrap();
        write!(text, "Wavelength\t7\t4\t640.0{end}Aspect\t7\t4\t{}{end}", cell[1] / cell[0]).unwrap();
        write!(text, "Pixel_size\t7\t4\t{}{end}RAW_DATA\t3\t9{end}{columns}", cell[0] * 1e-3).unwrap();
        let found = read(&text);
        assert_eq!((found.unit.as_deref(), aspect), (Some("µm"), true));
        check(&found, &map, if waves { 0.64 } else { 1e-3 }, Some(lengths), &text);
        // Keyence.
        let german = random.yes();
        let mut text = String::new();
        for (english, words, value) in [
            ("Model name", "Modell", "\"VK-X\""),
            ("XY calibration", "XY-Justierung", "\"500\",\"nm\""),
            ("Output image data", "Bilddatenausg.", if german { "\"Höhe\"" } else { "\"Height\"" }),
            ("Horizontal", "Horizont.", &format!("\"{nx}\"")),
            ("Vertical", "Vertikal", &format!("\"{ny}\"")),
            ("Minimum value", "Minimum", "\"-4\""),
            ("Unit", "Einheit", "\"um\""),
        ] {
            write!(text, "\"{}\",{value}{end}", if german { words } else { english }).unwrap();
        }
        let table = rows(true, "", ",").lines().fold(String::new(), |all, line| {
            all + &line.split(',').map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(",") + end
        });
        text += &format!("{end}\"Height\"{end}{table}");
        let found = read(&text);
        assert_eq!(found.unit.as_deref(), Some("µm"));
        check(&found, &map, 1.0, Some([0.5 * nx as f64, 0.5 * ny as f64]), &text);
        // Zygo.
        let origin = [random.of(0..9), random.of(0..9)];
        let points: String = (0..ny)
            .flat_map(|line| (0..nx).map(move |i| (i, line)))
            .map(|(i, line)| {
                let height = value(i, ny - 1 - line, "No Data");
                format!("{} {} {height}{end}", origin[0] + i, origin[1] + line)
            })
            .collect();
        let text = format!(
            "Zygo XYZ Data File - Format 1{end}0 0 0 0 \"\"{end}0 0 0 0 0 0{end}{} {} {nx} {ny}{end}\"\"{end}\"\"{end}\
             \"\"{end}0 0.5 6.3e-7 0 1 0 2e-6 0{end}0{end}0{end}0{end}0{end}#{end}{points}#{end}",
            origin[0], origin[1]
        );
        check(&read(&text), &map, 1.0, Some([2.0 * nx as f64, 2.0 * ny as f64]), &text);
    }
}

/// Returns a surface of 6 x 5 points, spacing 0.5, as rows of words of its points.
fn nodes(line: impl Fn(usize, f64, f64, f64) -> String) -> String {
    (0..30)
        .map(|k| (k, 0.5 * (k % 6) as f64, 0.5 * (k / 6) as f64))
        .map(|(k, x, y)| line(k, x, y, bumpy(x, y)))
        .collect()
}

fn bumpy(x: f64, y: f64) -> f64 {
    ((1.0 + (2.0 * x).sin() - (1.7 * y).sin() + 0.3 * x * y) * 1e4).round() / 1e4
}

#[test]
fn lists_among_other_columns_are_lists() {
    let expected = Array2::from_shape_fn((6, 5), |(i, j)| bumpy(0.5 * i as f64, 0.5 * j as f64));
    for text in [
        nodes(|k, x, y, z| format!("{x} {y} {z} {}\n", 7 * k % 41)),
        nodes(|k, x, y, z| format!("{},{x},{y},{z}\n", k + 1)),
        format!("node,x,y,z\n{}", nodes(|k, x, y, z| format!("{k},{x},{y},{z}\n"))),
        format!("z;quality;y;x\n{}", nodes(|k, x, y, z| format!("{z};{};{y};{x}\n", k % 7))),
        format!("# x y z intensity\n{}", nodes(|k, x, y, z| format!("{x}\t{y}\t{z}\t{k}\n"))),
    ] {
        check(&read(&text), &expected, 1.0, Some([3.0, 2.5]), &text);
    }
    let with_units = format!("node,x [mm],y [mm],z [um]\n{}", nodes(|k, x, y, z| format!("{k},{x},{y},{z}\n")));
    let found = read(&with_units);
    check(&found, &expected, 1e-3, Some([3.0, 2.5]), &with_units);
    assert_eq!(found.unit.as_deref(), Some("mm"));
    // Columns that form a lattice, without a column after them that must be the height.
    for text in [
        nodes(|k, x, y, z| format!("{z} {} {x} {y}\n", k % 7)),
        nodes(|k, x, y, z| format!("{x} {z} {y} {}\n", k % 7)),
        nodes(|_, x, y, z| format!("{z} {x} {y}\n")),
    ] {
        let reason = refusal(&text);
        assert!(reason.contains("lattice") && reason.contains("must"), "{reason}");
    }
    // Numbers and places of the points, without names.
    let text = nodes(|k, x, y, z| format!("{} {} {x} {y} {z}\n", k % 6, k / 6));
    assert!(refusal(&text).contains("are both those of a lattice; a line above must name x, y and z"));
    check(&read(&format!("i j x y z\n{text}")), &expected, 1.0, Some([3.0, 2.5]), &text);
    // Points off any lattice.
    let scattered = nodes(|k, _, y, z| format!("{:.3} {y} {z} 1\n", (1.3 * k as f64).sin()));
    assert!(refusal(&scattered).contains("may be points or a matrix"));
    // Several profiles side by side, with and without names.
    let profiles: String = (0..24)
        .map(|k| f64::from(k) * 0.25)
        .fold(String::new(), |all, x| all + &format!("{x:.2} {:.4} {x:.2} {:.4}\n", x.sin(), x.cos()));
    for text in [profiles.clone(), format!("x1 z1 x2 z2\n{profiles}")] {
        assert!(advises(&refusal(&text)));
    }
    let reason = refusal(&format!("x (mm),raw (um),waviness (um)\n{}", nodes(|_, x, y, z| format!("{x},{y},{z}\n"))));
    assert_eq!(reason, "a column is called x, but none z or height; one must be");
    // A narrow map with a column that rises unevenly.
    let narrow: String = (0..20)
        .map(|k| f64::from(k * k) * 0.1)
        .fold(String::new(), |all, x| all + &format!("{x:.2} {:.4} {:.4}\n", x.sin(), x.cos()));
    assert!(advises(&refusal(&narrow)));
}

#[test]
fn profiles_may_fall_and_must_not_turn_back() {
    let falling: String =
        (0..20).map(|k| format!("{:.3} {:.5}\n", 4.75 - 0.25 * f64::from(k), f64::from(k).sin())).collect();
    let map = read(&falling);
    assert_eq!((map.heights.dim(), map.lengths), ((20, 1), Some([5.0, 1.0])));
    assert_eq!(map.heights[[19, 0]], 0.0);
    for text in ["0 1\n0.25 2\n0.25 3\n0.5 1\n0.75 2\n", "0 1\n1 2\n2 3\n1 4\n2 3\n", "0 1\n0 2\n0 3\n0 4\n"] {
        let reason = refusal(text);
        assert!(reason.contains("it must rise, or fall, from point to point"), "{reason}");
    }
}

#[test]
fn labels_of_rows_and_columns_are_no_heights() {
    let expected = ndarray::array![[1.0, 2.0, 1.5], [2.0, 1.0, 2.5], [3.0, 2.5, 1.0]];
    let named = read("x,0,0.5,1.0\n0,1.0,2.0,3.0\n0.5,2.0,1.0,2.5\n1.0,1.5,2.5,1.0\n");
    assert_eq!((named.heights, named.lengths), (expected.clone(), Some([1.5, 1.5])));
    let numbered = read(",0,1,2\n0,1.0,2.0,3.0\n1,2.0,1.0,2.5\n2,1.5,2.5,1.0\n");
    assert_eq!((numbered.heights, numbered.lengths), (expected, None));
    let with_unit = "y/x (um),0,0.5,1.0\n0,1.0,2.0,3.0\n0.5,2.0,1.0,2.5\n1.0,1.5,2.5,1.0\n";
    assert_eq!(read(with_unit).lengths, Some([1.5, 1.5]));
    // A corner that is a number may be a height.
    for corner in ["0", "6"] {
        let text = "- 0.5 1.0 1.5 2.0 2.5\n0.5 1.7 0.4 0.9 2.2 1.8\n1.0 0.9 0.1 0.1 0.4 0.3\n1.5 0.1 1.4 0.7 0.1 0.4\n\
                    2.0 0.6 0.3 0.5 0.1 0.9\n";
        let text = text.replacen('-', corner, 1);
        let reason = refusal(&text);
        assert!(reason.contains("the corner must be left empty") && advises(&reason), "{reason}");
        assert_eq!(read(&text.replacen(corner, "nan", 1)).lengths, Some([2.5, 2.0]));
    }
    // Without row labels, as programs write column numbers.
    let reason = refusal("0,1,2,3,4\n1.7,0.4,0.9,2.2,1.8\n-0.9,0.9,-0.1,-0.1,0.4\n0.1,1.4,0.7,0.1,0.4\n");
    assert!(reason.contains("labels of columns") && advises(&reason), "{reason}");
    // A short matrix of whole numbers, a plane, a wave along y have no labels.
    for text in ["1 2 4 5\n2 1 3 3\n", "0 1 2 3 4\n1 2 3 4 5\n2 3 4 5 6\n", "0 0 0 0 0\n1 1 1 1 1\n0 0 0 0 0\n"] {
        assert_eq!(read(text).heights.ncols(), text.lines().count(), "{text}");
    }
}

#[test]
fn heads_that_are_known_are_read_and_others_are_named() {
    let found = read("\\Exported image units: nm\n1.0 2.0 3.0\n2.0 1.5 0.5\n0.5 2.5 1.0\n");
    assert_eq!((found.unit.as_deref(), found.lengths, found.warnings.len()), (Some("nm"), None, 0));
    let found = read("Sampling step: 0.5 um\nOperator: me\n1.0 2.0 3.0\n2.0 1.5 0.5\n0.5 2.5 1.0\n");
    assert_eq!((found.unit, found.lengths, found.warnings.len()), (None, None, 1));
    assert!(found.warnings[0].contains("Sampling step: 0.5 um"), "{:?}", found.warnings);
    assert!(!found.warnings[0].contains("Operator"), "{:?}", found.warnings);
    let found = read("north: 2.5\nsouth: 0\nrows: 2\nnull: -9999\n1.0 2.0 3.5\n2.0 1.5 0.5\n");
    assert!(found.warnings[0].contains("north: 2.5") && found.warnings[0].contains("null: -9999"));
    // Esri keys in any order, after a comment.
    let grid = read("# made\ncellsize: 0.5\nnrows: 2\nncols: 3\n1 2 3\n4 -9999 6\n");
    assert_eq!((grid.lengths, grid.heights[[0, 0]], grid.undefined), (Some([1.5, 1.0]), 4.0, 1));
    // Keyence in other languages: the pixel line has three fields, the unit line two.
    let grid = read("\"Etalonnage XY\",\"500\",\"nm\"\n\"Unite\",\"um\"\n\n\"Hauteur\"\n\"1\",\"2\"\n\"4\",\"3\"\n");
    assert_eq!((grid.lengths, grid.unit.as_deref()), (Some([1.0, 1.0]), Some("µm")));
    // Nanoscope writes a line for each pixel, with a column for each channel.
    let pixels: String = (0..12).map(|k| format!("{}.5\t{}\t{}\n", k, 2 * k, 7 - k)).collect();
    let head = "\"\\*File list\"\n\"\\Samps/line: 4\"\n\"\\Lines: 3\"\n\"\\Scan Size: 2 um\"\n\
                Height_Sensor(nm)\tPhase(Deg)\tHeight(nm)\n";
    let found = read(&format!("{head}{pixels}"));
    assert_eq!((found.channels.len(), found.channel.as_deref()), (2, Some("Height_Sensor")));
    assert_eq!((found.heights.dim(), found.unit.as_deref()), ((4, 3), Some("µm")));
    assert!((found.heights[[1, 2]] - 1.5e-3).abs() < 1e-17 && (found.heights[[0, 0]] - 8.5e-3).abs() < 1e-17);
    assert_eq!(found.lengths, Some([2.0, 1.5]));
    // The number of lines follows from the number of pixels.
    let short = format!("{head}{pixels}").replace("\"\\Lines: 3\"\n", "");
    assert_eq!(read(&short).heights, found.heights);
    let reason = refusal(&format!("{head}{pixels}").replace("Lines: 3", "Lines: 5"));
    assert!(reason.contains("12 lines of 3 numbers") && advises(&reason), "{reason}");
}

#[test]
fn words_for_missing_points_are_known() {
    for word in MISSING.iter().chain(&["No Data", "1.#INF", "<NA>", "n/a", "Invalid", "n.d.", "—", "--.--", "#REF!"])
    {
        let text = format!("1.5,2.0,0.5,1.0\n2.5,{word},3.0,0.5\n1.0,2.0,1.5,0.25\n");
        let found = read(&text);
        assert_eq!((found.undefined, found.heights[[1, 1]].is_nan()), (1, true), "{word}");
        let blanks = text.replace(',', "\t");
        assert_eq!(read(&blanks).undefined, 1, "{word}");
    }
    let blanks = read("1.5 2.0 0.5 1.0\n2.5 *** 3.0 No Data\n1.0 ? 1.5 0.25\n");
    assert_eq!(blanks.undefined, 3);
    for word in ["1_0", "5um", "high", "1.2.3"] {
        assert!(refusal(&format!("1.5,2.0,0.5\n2.5,{word},3.0\n")).ends_with("it must be a number"));
    }
    for word in ["inf", "-inf", "+Infinity"] {
        assert_eq!(read(&format!("1.5,2.0,0.5\n2.5,{word},3.0\n")).undefined, 1, "{word}");
    }
    for word in ["1e999", "-1e309", "2.0D+400", "1.0+400"] {
        let says = format!("line 2, column 2 is {word:?}, which is out of range; it must be at most 1.8e308");
        assert_eq!(refusal(&format!("1.5,2.0,0.5\n2.5,{word},3.0\n")), says);
    }
}

#[test]
fn numbers_that_stand_for_missing_points_are_named() {
    for number in ["-9999", "-32768", "-25400", "3.4028e38", "1e10", "1.7976931348623157e308"] {
        let text = format!("1.5,{number},0.5,1.0\n2.5,0.5,3.0,0.5\n1.0,2.0,{number},0.25\n");
        let [warning] = &read(&text).warnings[..] else { panic!("{number}") };
        assert!(warning.contains("at 2 points, far outside all others"), "{warning}");
    }
    let array = ndarray::array![[1.5, -9999.0], [0.25, 2.0], [1.0, 0.5]].into_dyn();
    assert_eq!(Topography::of_array("heights", &array.view()).unwrap().warnings.len(), 1);
    assert!(read("1.5,4.0,0.5,1.0\n2.5,0.5,3.0,0.5\n").warnings.is_empty());
    // The end of the last number is lost, or one number is from elsewhere.
    for last in ["-7.5542e-0", "1e-3", "1", "7.55", "-1000"] {
        let line = |j: usize| (0..9).map(|i| format!("{:.4e}\t", 1e-8 * (1.3 * (i * j + i) as f64).sin())).collect();
        let lines: Vec<String> = (0..9).map(line).collect();
        assert!(read(&lines.join("\n")).warnings.is_empty());
        let cut = lines.join("\n").rsplit_once('\t').unwrap().0.rsplit_once('\t').unwrap().0.to_owned();
        let [warning] = &read(&format!("{cut}\t{last}\n")).warnings[..] else { panic!("{last}") };
        assert!(warning.starts_with("1 height, ") && warning.contains(", is far outside all others, "), "{warning}");
    }
}

#[test]
fn formats_that_are_not_read_are_named_with_a_way_out() {
    for (bytes, name) in [
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0\0\0\0".to_vec(), "OLE"),
        (b"BZh91AY".to_vec(), "bzip2"),
        (b"OFF\n3 1 0\n0 0 1\n".to_vec(), "OFF mesh"),
        (b"II+\0\x08\0\0\0".to_vec(), "BigTIFF"),
        (b"STiMage 3.1\0\0".to_vec(), "RHK SM4"),
        (b"[[1, 2], [3, 4]]\n".to_vec(), "JSON"),
    ] {
        let reason = Topography::from_bytes("scan", bytes, None).unwrap_err().reason;
        assert!(reason.contains(name) && reason.contains("is not read; "), "{reason}");
    }
    for list in ["- 1.0\n- 2.0\n- 3.0\n", "- 1.0 2.0\n- 2.0 3.0\n"] {
        assert!(refusal(list).contains("YAML"));
    }
}

#[test]
fn heads_of_instruments_give_size_and_unit() {
    let dektak: String =
        (0..40).map(|k| format!("{:.1},{:.5},\n", 0.2 * f64::from(k), (0.3 * f64::from(k)).sin())).collect();
    let found = read(&format!("Lateral um,Raw Micrometer,\n{dektak}"));
    assert_eq!((found.heights.dim(), found.unit.as_deref()), ((40, 1), Some("µm")));
    assert!((found.lengths.unwrap()[0] - 8.0).abs() < 1e-9);
    // A spacing of 0.15625 with one decimal.
    let rounded: String =
        (0..200).map(|k| format!("{:.1},{:.5}\n", 0.15625 * f64::from(k), (0.3 * f64::from(k)).sin())).collect();
    let found = read(&rounded);
    assert!((found.lengths.unwrap()[0] - 31.25).abs() < 1e-3, "{:?}", found.lengths);
    assert!(rms(&found) > 0.5);
    // Numbers with three digits, as written by %.3g and %.2e.
    for text in [
        (0..144).map(|k| format!("{} {} {}.5\n", three(k % 12), three(k / 12), k * k % 31)).collect::<String>(),
        (0..144)
            .map(|k| {
                format!("{:.2e} {:.2e} {}.5\n", 0.15625 * f64::from(k % 12), 0.15625 * f64::from(k / 12), k * k % 31)
            })
            .collect(),
    ] {
        let found = read(&text);
        assert_eq!(found.heights.dim(), (12, 12));
        found.lengths.unwrap().iter().for_each(|length| assert!((length / 1.875 - 1.0).abs() < 0.01, "{length}"));
    }
}

/// Formats a multiple of 0.15625 with three digits and without trailing zeros.
fn three(k: i32) -> String {
    let value = 0.15625 * f64::from(k);
    let decimals = if value < 1.0 { 3 } else { 2 };
    let text = format!("{value:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[test]
fn utf_16_has_either_order_of_bytes() {
    let text = "# Width: 3 µm\r\n# Height: 2 µm\r\n# Value units: nm\r\n1 2 3\r\n4 5 \u{2212}6\r\n";
    for to_bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(to_bytes).collect();
        let found = Topography::from_bytes("scan", bytes, None).unwrap();
        assert_eq!(found.heights, ndarray::array![[1.0, 4.0], [2.0, 5.0], [3.0, -6.0]]);
        assert_eq!((found.lengths, found.unit.as_deref()), (Some([3e3, 2e3]), Some("nm")));
    }
}

#[test]
fn entries_of_a_head_must_not_contradict_each_other() {
    let table = |head: &str| format!("# Width: 9 um\n# Height: 6 um\n# Value units: nm\n{head}1 2 3\n4 5 6\n");
    for (line, says) in [
        ("# Width: 18 um", "the width is 18 um, and a line before says 9 um"),
        ("# Width: 9", "the width is 9, and a line before says 9 um"),
        ("# Höhe: 6 mm", "the height is 6 mm, and a line before says 6 um"),
        ("# Value units: um", "the unit is um, and a line before says nm"),
        ("# Height conversion factor (-> m): 2", "the unit is m, and a line before says nm"),
        ("# NODATA: 5\n# nodata_value: 6", "the number of missing points is 6, and a line before says 5"),
        ("# Channel: A\n# Channel: B", "the channel is B, and a line before says A"),
        ("# pixel size: 3 um\n# pixel size: 3 nm", "the pixel size is 3 nm, and a line before says 3 um"),
    ] {
        let number = 3 + line.lines().count();
        assert_eq!(refusal(&table(&format!("{line}\n"))), format!("line {number} says that {says}; both must agree"));
    }
    let same = read(&table("# Width: 9000 nm\n# Height: 6.0 µm\n# Value units: nm\n"));
    assert_eq!((same.lengths, same.unit.as_deref()), (Some([9e3, 6e3]), Some("nm")));
}

#[test]
fn a_point_that_is_listed_again_is_named() {
    let list = nodes(|_, x, y, z| format!("{x} {y} {z}\n")) + "1.5 0.5 7\n";
    for head in ["", "x y z\n", "# by a program\n"] {
        let reason = refusal(&format!("{head}{list}"));
        assert!(reason.contains(" (point 31 has the x and y of point 10, 1.5 and 0.5); they must be"), "{reason}");
    }
    let short = refusal("0 0 5\n1 0 4\n2 0 7\n0 1 3\n1 1 9\n2 1 8\n2 0 1\n");
    assert!(short.contains(" (point 7 has the x and y of point 3, 2 and 0); they must be"), "{short}");
}

#[test]
fn heights_of_a_surfer_grid_outside_its_range_are_a_warning() {
    for (range, count) in
        [("1 4", 0), ("0.5 3.9", 0), ("0 0", 0), ("-9 9", 0), ("1.04 4", 1), ("1.4 3.96", 1), ("1.37 3.94", 2)]
    {
        let map = read(&format!("DSAA\n2 2\n0 1\n0 1\n{range}\n1 2 1.70141e38\n3.96\n"));
        assert_eq!((map.undefined, map.warnings.len()), (1, usize::from(count > 0)), "{range}: {:?}", map.warnings);
        let start = format!("{count} of 4 heights are outside the range in the head, {}, ", range.replace(' ', " to "));
        assert!(map.warnings.iter().all(|warning| warning.starts_with(&start)), "{:?}", map.warnings);
    }
}

#[test]
fn a_profile_without_some_points_has_undefined_points_or_is_refused() {
    let list = |missing: &[usize], x: &dyn Fn(usize) -> String, n: usize| -> String {
        let kept = (0..n).filter(|k| !missing.contains(k));
        kept.map(|k| format!("{} {:.4}\n", x(k), (0.3 * k as f64).sin())).collect()
    };
    let general = |digits: usize, step: f64| {
        move |k: usize| format!("{:.digits$}", step * k as f64).trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    for (missing, x, n, step) in [
        (&[50][..], &(|k: usize| k.to_string()) as &dyn Fn(usize) -> String, 100, 1.0),
        (&[5], &general(1, 0.5), 20, 0.5),
        (&[3, 4, 7, 15], &general(1, 0.5), 20, 0.5),
        (&[1, 50, 97], &|k| format!("{:.3}", 0.1 * k as f64), 100, 0.1),
        (&[20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31], &|k| (3 * k).to_string(), 60, 3.0),
    ] {
        for falls in [false, true] {
            let mut lines: Vec<String> = list(missing, x, n).lines().map(|line| line.to_owned() + "\n").collect();
            if falls {
                lines.reverse();
            }
            let map = read(&lines.concat());
            assert_eq!((map.heights.dim(), map.undefined), ((n, 1), missing.len()));
            assert!((map.lengths.unwrap()[0] - step * n as f64).abs() < 1e-9, "{:?}", map.lengths);
            for (k, height) in map.heights.iter().enumerate() {
                let is_right = match missing.contains(&k) {
                    true => height.is_nan(),
                    false => (height - (0.3 * k as f64).sin()).abs() < 1e-4,
                };
                assert!(is_right, "{k}: {height}");
            }
            let note =
                format!("{} of {n} points of the profile are not in the list; they are undefined", missing.len());
            assert_eq!(map.notes, [note]);
        }
    }
    for x in [&(|k: usize| format!("{:.1}", 0.1 * k as f64)) as &dyn Fn(usize) -> String, &general(1, 0.1)] {
        let reason = refusal(&list(&[50], x, 100));
        let says = "the coordinates x are not even: they are written to 1e-1 only, and may be rounded or have gaps; ";
        assert!(reason.starts_with(says) && advises(&reason), "{reason}");
    }
    // Points that are marked stay with their heights.
    let marked = read("X;Y;valid\n3;4.5;0\n2;3.5;1\n1;2.5;1\n0;1.5;1\n");
    assert_eq!((marked.undefined, marked.heights[[0, 0]], marked.heights[[3, 0]].is_nan()), (1, 1.5, true));
    // Labels of a matrix.
    let rows: Vec<String> = (0..40).filter(|k| *k != 20).map(|k| format!("{k},1.5,2.5,{k}.5\n")).collect();
    let reason = refusal(&format!("y\\x,0,1,2\n{}", rows.concat()));
    assert!(reason.starts_with("the labels of rows ") && advises(&reason), "{reason}");
}

#[test]
fn decimal_commas_between_commas_are_refused() {
    let mut random = Random(9);
    let mut table = |lines: usize, cell: &mut dyn FnMut(&mut Random) -> String| -> String {
        let mut line = || (0..4).map(|_| cell(&mut random)).collect::<Vec<_>>().join(",") + "\n";
        (0..lines).map(|_| line()).collect()
    };
    let number = |random: &mut Random, range: std::ops::Range<usize>| random.of(range) as f64 / 1e3;
    for (name, text) in [
        ("signs", table(32, &mut |random| format!("{:.3}", number(random, 0..4000) - 2.0).replace('.', ","))),
        ("no signs", table(8, &mut |random| format!("{:.3}", number(random, 0..4000)).replace('.', ","))),
        ("no zeros", table(8, &mut |random| format!("{:.3}", number(random, 100..999)).replace('.', ","))),
        ("short", table(9, &mut |random| (number(random, 0..4000) - 2.0001).to_string().replace('.', ","))),
        ("exponents", table(2, &mut |random| format!("{:.3e}", 1e-9 * number(random, 1..4000)).replace('.', ","))),
        ("minus zero", "-0,3,0,5\n0,7,0,9\n".into()),
        ("a profile", "0,25\n1,05\n2,15\n3,75\n".into()),
    ] {
        let reason = refusal(&text);
        assert!(reason.starts_with("the commas may ") && advises(&reason), "{name}: {reason}");
    }
    for (name, text) in [
        ("whole", table(9, &mut |random| format!("{},{}", random.of(0..99), random.of(0..99)))),
        ("signs", table(9, &mut |random| (random.of(0..99) as f64 - 50.0).to_string())),
        ("padded", table(9, &mut |random| format!("{:03},{:03}", random.of(0..400), random.of(0..400)))),
        ("large", table(9, &mut |random| format!("{},{}", random.of(10..400), random.of(10..400)))),
        ("two digits", table(9, &mut |random| format!("{},{}", random.of(10..100), random.of(10..100)))),
        ("points", table(9, &mut |random| format!("{},{:.3}", random.of(0..9), number(random, 0..999)))),
        ("small", "1,12\n2,15\n3,10\n4,99\n".into()),
        ("binary", "0,1,0,1,0,1\n0,1,0,1,0,1\n".into()),
    ] {
        if let Err(reason) = parse(&text) {
            assert!(!reason.starts_with("the commas may "), "{name}: {reason}\n{text}");
        }
    }
}
