//! Finished figures: SVG text with embedded images, rendered to PNG by `resvg` with the bundled font only.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use resvg::tiny_skia::{FilterQuality, Pixmap, PixmapPaint, Transform};
use resvg::usvg::{self, fontdb};

use super::PlotError;
use super::colour::Rgb;
use super::text::{FAMILY, ITALIC, REGULAR, escape, number};

/// Dots per inch of a PNG, unless its pictures need more.
const RESOLUTION: f64 = 300.0;

/// Points per inch.
const POINTS: f64 = 72.0;

/// Largest number of colours of a picture with one byte per pixel.
pub(super) const INDEXED: usize = 256;

/// Compression of pictures. The highest level takes ten times as long, for files a few per cent smaller.
const EFFORT: png::DeflateCompression = png::DeflateCompression::Level(4);

/// Image in the drawing; its first row is at the top.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    /// Left, top, width and height in the drawing, in points.
    pub(super) frame: [f64; 4],
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Colours of the pixels. Similar colours are neighbours, so that differences of indices are small.
    pub(super) palette: Vec<Rgb>,
    /// Index of the colour of each pixel.
    pub(super) pixels: Vec<u32>,
}

/// Figure; all lengths are in points, with y downwards.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Images, drawn below the elements.
    pub(super) pictures: Vec<Picture>,
    pub(super) elements: String,
}

impl Drawing {
    pub(super) fn svg(&self) -> Result<String, PlotError> {
        let mut pictures = String::from("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n");
        for picture in &self.pictures {
            let [x, y, width, height] = picture.frame.map(number);
            let data = base64::engine::general_purpose::STANDARD.encode(picture.encode()?);
            let rendering = if picture.is_coarse() { r#" style="image-rendering:pixelated""# } else { "" };
            pictures.push_str(&format!(
                "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                 preserveAspectRatio=\"none\"{rendering} href=\"data:image/png;base64,{data}\"/>\n"
            ));
        }
        Ok(self.wrap(&pictures))
    }

    /// Returns the figure as an element of a page. Ids begin with `name`, since a page has several figures; `title` is
    /// the alternative text.
    pub(super) fn element(&self, name: &str, title: &str) -> Result<String, PlotError> {
        let svg = self.svg()?;
        let element = svg.split_once("?>\n").map_or(svg.as_str(), |(_, element)| element);
        let title = format!(" role=\"img\">\n<title>{}</title>\n", escape(title));
        Ok(with_ids(element, name).replacen(">\n", &title, 1))
    }

    /// Places drawings side by side, from left to right.
    pub(super) fn row(drawings: impl IntoIterator<Item = Self>) -> Self {
        let mut row = Self { width: 0.0, height: 0.0, pictures: Vec::new(), elements: String::new() };
        for (index, drawing) in drawings.into_iter().enumerate() {
            let moved = |picture: Picture| {
                let [left, top, width, height] = picture.frame;
                Picture { frame: [left + row.width, top, width, height], ..picture }
            };
            row.pictures.extend(drawing.pictures.into_iter().map(moved));
            let elements = with_ids(&drawing.elements, &format!("part{index}"));
            row.elements += &format!("<g transform=\"translate({} 0)\">\n{elements}</g>\n", number(row.width));
            row.width += drawing.width;
            row.height = row.height.max(drawing.height);
        }
        row
    }

    pub(super) fn png(&self) -> Result<Vec<u8>, PlotError> {
        let render = |reason: &dyn ToString| PlotError::Render { reason: reason.to_string() };
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(REGULAR.to_vec());
        fonts.load_font_data(ITALIC.to_vec());
        let options =
            usvg::Options { fontdb: Arc::new(fonts), font_family: "Arimo".into(), ..usvg::Options::default() };
        let tree = usvg::Tree::from_str(&self.wrap(""), &options).map_err(|error| render(&error))?;

        let resolution = self.pictures.iter().map(Picture::resolution).fold(RESOLUTION, f64::max);
        let scale = resolution / POINTS;
        let [width, height] = [self.width, self.height].map(|length| (length * scale).round() as u32);
        let mut page = Pixmap::new(width, height).ok_or_else(|| render(&"the figure has no area"))?;
        page.fill(resvg::tiny_skia::Color::WHITE);
        for picture in &self.pictures {
            picture.paint(&mut page, scale).ok_or_else(|| render(&"a picture has no area"))?;
        }
        // `usvg` has converted points to its own pixels.
        let stretch = width as f32 / tree.size().width();
        resvg::render(&tree, Transform::from_scale(stretch, stretch), &mut page.as_mut());
        let pixels: Vec<Rgb> = page.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect(); // opaque
        encode([width, height], None, pixels.as_flattened(), Some(resolution))
    }

    pub(super) fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        let with = |extension: &str| {
            let mut name = stem.file_name().unwrap_or_default().to_os_string();
            name.push(extension);
            stem.with_file_name(name)
        };
        let paths = [with(".svg"), with(".png")];
        let contents = [self.svg()?.into_bytes(), self.png()?];
        for (path, content) in paths.iter().zip(contents) {
            replace(path, &content).map_err(|source| PlotError::Io { path: path.clone(), source })?;
        }
        Ok(paths)
    }

    fn wrap(&self, under: &str) -> String {
        let [width, height] = [self.width, self.height].map(number);
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}\">\n{under}{}</svg>\n",
            self.elements
        )
    }
}

impl Picture {
    /// Returns the dots per inch at which every pixel has a dot.
    fn resolution(&self) -> f64 {
        let [_, _, width, height] = self.frame;
        POINTS * (self.columns as f64 / width).max(self.rows as f64 / height)
    }

    /// Returns true if the pixels are large enough to be visible as squares.
    fn is_coarse(&self) -> bool {
        self.columns as f64 * 3.0 < self.frame[2] * RESOLUTION / POINTS
    }

    /// Returns the colours of the pixels.
    pub(super) fn colours(&self) -> impl Iterator<Item = Rgb> {
        self.pixels.iter().map(|&index| self.palette[index as usize])
    }

    /// Returns the picture as PNG bytes, with one byte per pixel if the colours are few.
    fn encode(&self) -> Result<Vec<u8>, PlotError> {
        let size = [self.columns, self.rows].map(|length| length as u32);
        if self.palette.len() <= INDEXED {
            let indices: Vec<u8> = self.pixels.iter().map(|&index| index as u8).collect();
            return encode(size, Some(&self.palette), &indices, None);
        }
        let colours: Vec<Rgb> = self.colours().collect();
        encode(size, None, colours.as_flattened(), None)
    }

    fn paint(&self, page: &mut Pixmap, scale: f64) -> Option<()> {
        let mut source = Pixmap::new(self.columns as u32, self.rows as u32)?;
        for (target, rgb) in source.pixels_mut().iter_mut().zip(self.colours()) {
            *target = resvg::tiny_skia::PremultipliedColorU8::from_rgba(rgb[0], rgb[1], rgb[2], 255)?;
        }
        let [mut x, mut y, width, height] = self.frame.map(|length| length * scale);
        let stretch = [width / self.columns as f64, height / self.rows as f64].map(|s| s as f32);
        // A picture with one dot per pixel is aligned to the dots.
        let is_fine = self.resolution() * (1.0 + 1e-9) > scale * POINTS;
        if is_fine {
            (x, y) = (x.round(), y.round());
        }
        let transform = Transform::from_row(stretch[0], 0.0, 0.0, stretch[1], x as f32, y as f32);
        let quality = if is_fine || self.is_coarse() { FilterQuality::Nearest } else { FilterQuality::Bilinear };
        page.draw_pixmap(0, 0, source.as_ref(), &PixmapPaint { quality, ..PixmapPaint::default() }, transform, None);
        Some(())
    }
}

/// Prefixes the ids of the elements with `name`.
fn with_ids(elements: &str, name: &str) -> String {
    // Quotes are escaped in texts, so these are attributes.
    elements.replace(" id=\"", &format!(" id=\"{name}-")).replace("\"url(#", &format!("\"url(#{name}-"))
}

/// Encodes pixels as PNG: indices of a palette, or bytes of red, green and blue.
fn encode(
    [width, height]: [u32; 2],
    palette: Option<&[Rgb]>,
    pixels: &[u8],
    resolution: Option<f64>,
) -> Result<Vec<u8>, PlotError> {
    let render = |error: png::EncodingError| PlotError::Render { reason: error.to_string() };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(if palette.is_some() { png::ColorType::Indexed } else { png::ColorType::Rgb });
    if let Some(palette) = palette {
        encoder.set_palette(palette.as_flattened());
    }
    encoder.set_deflate_compression(EFFORT);
    encoder.set_filter(png::Filter::Adaptive);
    if let Some(dots_per_inch) = resolution {
        let per_metre = (dots_per_inch / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
    }
    let mut writer = encoder.write_header().map_err(render)?;
    writer.write_image_data(pixels).map_err(render)?;
    writer.finish().map_err(render)?;
    Ok(bytes)
}

/// Writes a file beside the target and renames it, so that an incomplete file never has the name of the target.
fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut part = path.as_os_str().to_os_string();
    part.push(".part");
    fs::write(&part, content).and_then(|()| fs::rename(&part, path)).inspect_err(|_| {
        let _ = fs::remove_file(&part);
    })
}
