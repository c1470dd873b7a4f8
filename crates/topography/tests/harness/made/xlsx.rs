//! Workbooks of Excel.

use super::{POINTS, height, is_undefined};

/// Returns the members of a workbook with sheets of these names and contents.
fn book(sheets: &[(&str, String)], strings: &[&str]) -> Vec<(&'static str, Vec<u8>)> {
    const MEMBERS: [&str; 2] = ["xl/worksheets/sheet1.xml", "xl/worksheets/sheet2.xml"];
    let listed =
        |(k, (name, _)): (usize, &(&str, String))| format!("<sheet name=\"{name}\" sheetId=\"{k}\" r:id=\"rId{k}\"/>");
    let names: String = sheets.iter().enumerate().map(listed).collect();
    let related = |k: usize| format!("<Relationship Id=\"rId{k}\" Target=\"{}\"/>", &MEMBERS[k][3..]);
    let relations: String = (0..sheets.len()).map(related).collect();
    let strings: String = strings.iter().map(|text| format!("<si><t>{text}</t></si>")).collect();
    let text = |text: String| format!("<?xml version=\"1.0\"?>\n{text}").into_bytes();
    let mut members = vec![
        ("[Content_Types].xml", text("<Types/>".into())),
        ("xl/workbook.xml", text(format!("<workbook xmlns:r=\"u\"><sheets>{names}</sheets></workbook>"))),
        ("xl/_rels/workbook.xml.rels", text(format!("<Relationships>{relations}</Relationships>"))),
        ("xl/sharedStrings.xml", text(format!("<sst>{strings}</sst>"))),
    ];
    for (member, (_, rows)) in MEMBERS.iter().zip(sheets) {
        members.push((member, text(format!("<worksheet><sheetData>{rows}</sheetData></worksheet>"))));
    }
    members
}

/// Two sheets: a matrix of the squares of the heights, and points x y z in µm and nm with titles and spacings of 0.5
/// and 0.25 µm, the bottom line first; the point without a height is an empty cell.
pub(crate) fn xlsx() -> Vec<(&'static str, Vec<u8>)> {
    let [nx, ny] = POINTS;
    let value = |x: usize, y: usize, power: u32| {
        let y = ny - 1 - y;
        if is_undefined(nx * y + x) { String::new() } else { format!("<v>{}</v>", i32::from(height(x, y)).pow(power)) }
    };
    let cell = |x: usize, y: usize| {
        let letter = char::from(b"BCDEF"[x]);
        format!("<c r=\"{letter}{}\">{}</c>", y + 3, value(x, y, 2))
    };
    let row = |y: usize| format!("<row r=\"{}\">{}</row>", y + 3, (0..nx).map(|x| cell(x, y)).collect::<String>());
    let matrix: String = (0..ny).map(row).collect();
    let point = |k: usize| {
        let [x, y] = [k % nx, k / nx];
        let [along_x, along_y] = [0.5 * x as f64, 0.25 * y as f64];
        format!("<row><c><v>{along_x}</v></c><c t=\"n\"><v>{along_y}</v></c><c s=\"1\">{}</c></row>", value(x, y, 1))
    };
    let titles = (0..3).map(|k| format!("<c t=\"s\"><v>{k}</v></c>")).collect::<String>();
    let points = format!("<row>{titles}</row>{}", (0..nx * ny).map(point).collect::<String>());
    book(&[("Map", matrix), ("List", points)], &["x [\u{b5}m]", "y [&#181;m]", "z [nm]"])
}

/// Profile of Mitutoyo: positions in mm every 0.5 µm, heights of 0.125 µm per number.
pub(crate) fn mitutoyo() -> Vec<(&'static str, Vec<u8>)> {
    let row = |k: usize| {
        let parameter = if k == 1 { "<c r=\"A1\" t=\"s\"><v>0</v></c>" } else { "" };
        let [x, z] = [0.0005 * k as f64, 0.125 * f64::from(height(k, 0))];
        format!("<row r=\"{k}\">{parameter}<c r=\"E{k}\"><v>{x}</v></c><c r=\"F{k}\"><v>{z}</v></c></row>")
    };
    let certificate = "<row r=\"2\"><c r=\"E2\" t=\"inlineStr\"><is><t>29-Feb-2024</t></is></c></row>\
                       <row r=\"48\"><c r=\"E48\" t=\"s\"><v>1</v></c></row>";
    book(
        &[("DATA", (1..=4).map(row).collect()), ("Certificate", certificate.to_owned())],
        &["Ra 0.15 \u{b5}m", "0.8mm"],
    )
}
