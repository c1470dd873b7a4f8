//! Common parts of the VTK XML files: arrays declared in a header, with their values after it in binary form
//! ("appended", "raw", little-endian, 64-bit lengths).

use std::fmt::Write;

/// Bytes of a value, and of the length field before an array.
pub(crate) const VALUE: usize = size_of::<f64>();
pub(crate) const LENGTH: u64 = size_of::<u64>() as u64;

pub(crate) const FOOTER: &str = "\n</AppendedData>\n</VTKFile>\n";

/// Quantity at every point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointArray<'a> {
    /// Name of the quantity.
    pub name: &'a str,
    /// Names of the components; empty for a scalar. ParaView reads 3 components as a vector, 6 as a symmetric tensor.
    pub components: &'a [&'a str],
    /// Unit of the quantity; none if empty.
    pub units: &'a str,
}

impl PointArray<'_> {
    pub(crate) fn width(&self) -> usize {
        self.components.len().max(1)
    }
}

/// Header being written.
pub(crate) struct Header {
    pub(crate) text: String,
    /// Length of each array in bytes.
    pub(crate) bytes: Vec<u64>,
}

impl Header {
    /// Begins a file with data of the `kind`; `attributes` are the attributes of its element.
    pub(crate) fn new(kind: &str, attributes: &str) -> Self {
        let text = format!(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <{kind}{attributes}>\n"
        );
        Self { text, bytes: Vec::new() }
    }

    /// Adds lines to the text.
    pub(crate) fn add(&mut self, lines: &str) {
        self.text += lines;
        self.text.push('\n');
    }

    /// Declares values at `points` points. Programs show the first scalar when they open the file.
    pub(crate) fn point_data(&mut self, arrays: &[PointArray], points: usize) {
        let shown = arrays.iter().find(|array| array.components.is_empty());
        let shown = shown.map_or_else(String::new, |array| format!(" Scalars=\"{}\"", escape(array.name)));
        self.add(&format!("<PointData{shown}>"));
        arrays.iter().for_each(|array| self.declare("Float64", array, points));
        self.add("</PointData>");
    }

    /// Declares an array of `count` tuples of an eight-byte type.
    pub(crate) fn declare(&mut self, kind: &str, array: &PointArray, count: usize) {
        let offset: u64 = self.bytes.iter().map(|bytes| LENGTH + bytes).sum();
        let (name, width) = (escape(array.name), array.width());
        let _ = write!(self.text, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\"");
        for (k, name) in array.components.iter().enumerate() {
            let _ = write!(self.text, " ComponentName{k}=\"{}\"", escape(name));
        }
        let _ = write!(self.text, " format=\"appended\" offset=\"{offset}\"");
        let unit = escape(array.units);
        self.add(&match unit.is_empty() {
            true => "/>".into(),
            false => format!(
                ">\n<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>\n\
                 </DataArray>"
            ),
        });
        self.bytes.push((count * width * VALUE) as u64);
    }

    /// Returns the header up to the first appended byte, and the length of each array in bytes.
    pub(crate) fn end(mut self, kind: &str) -> (String, Vec<u64>) {
        self.text += &format!("</Piece>\n</{kind}>\n<AppendedData encoding=\"raw\">\n_");
        (self.text, self.bytes)
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
