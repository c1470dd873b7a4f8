//! Figures: their content in the thesis, and the commands that make them.

/// Figure of the thesis.
pub(super) struct Figure {
    pub(super) number: &'static str,
    /// Content of the figure in the thesis, in the words of its caption where the caption is right.
    pub(super) source: &'static str,
    /// Content of our figure.
    pub(super) here: &'static str,
    /// Error of the caption or of the comparison, if there is one.
    pub(super) erratum: &'static str,
    pub(super) work: Work,
}

#[derive(Clone, Copy)]
pub(super) enum Work {
    /// Pictures of the public commands.
    Commands(&'static [Picture]),
    /// Charts of the histories of several dampings.
    Dampings,
}

/// Picture drawn by a command.
pub(super) struct Picture {
    pub(super) command: &'static str,
    /// File name without extension.
    pub(super) file: &'static str,
    /// Words that distinguish it from other pictures of the figure.
    pub(super) suffix: &'static str,
}

const fn picture(command: &'static str, file: &'static str, suffix: &'static str) -> Picture {
    Picture { command, file, suffix }
}

impl Figure {
    /// Returns the file name of a picture.
    pub(super) fn file(&self, suffix: &str) -> String {
        format!("figure-{}{suffix}.svg", self.number)
    }

    /// Returns true if its commands read the file of the punch.
    pub(super) fn is_below_the_punch(&self) -> bool {
        matches!(self.work, Work::Commands(pictures) if pictures.iter().any(|p| p.command.contains("punch.h5")))
    }
}

/// Runs that write files for other commands.
pub(super) const PREPARATION: [&str; 1] = ["punch --tolerance 1e-10 --out punch.h5"];

/// Comparison on the surface: figures 4.3 to 4.6.
pub(super) const SURFACE: &str =
    "punch --tolerance 1e-10 --compare data/reference/punch3d_elements/u_n128.npy --plots top";

/// Comparison below the surface, on y = L/2 and on x = L/2: figures 4.7 to 4.11.
pub(super) const ALONG_X: &str = "body --surface punch.h5 --levels 65 --slice y=0.635 \
     --compare data/reference/punch3d_elements/section_y.npy --draw ux,sxx,sxz --plots along-x";
pub(super) const ALONG_Y: &str = "body --surface punch.h5 --levels 65 --slice x=0.635 \
     --compare data/reference/punch3d_elements/section_x.npy --draw ux,uy,uz,sxx,sxz --plots along-y";

/// Expands to the command for the wave of figure 3.2 on a slab.
macro_rules! wave {
    ($rest:literal) => {
        concat!("body --wave 1,1,z,0.5 --wave 1,-1,z,0.5 --young 1 --poisson 0.33 --height 1 ", $rest)
    };
}

const ABOVE_X: &str = wave!("--levels 65 --slice y=0 --draw ux,uz,exx,ezz,exz --plots y0");
const ABOVE_Y: &str = wave!("--levels 65 --slice x=0 --draw uy,eyy,eyz --plots x0");
const LEVEL: &str = wave!("--slice z=0.875 --draw ux,uy,uz,exx,eyy,ezz,exz,eyz,exy --plots level");

pub(super) const SPACE: &str =
    "body --wave 1,0,z,1 --young 1 --poisson 0.33 --height 1 --levels 65 --slice y=0.5 --draw ux,uz --plots space";
pub(super) const PLANE: &str =
    "body --wave 1,0,z,1 --n 64,1 --young 1 --poisson 0.33 --height 1 --levels 65 --draw ux,uz --plots plane";

/// All figures except the schematics 2.1, 2.2, 3.1, 3.2, 3.9 and 4.2.
pub(super) const FIGURES: [Figure; 19] = [
    Figure {
        number: "3.3",
        source: "u_x below the wave of figure 3.2, cos(2πx + 2πy) + cos(2πx − 2πy) of u_z, with u_x = u_y = 0 on the \
                 surface.",
        here: "u_x on y = 0, and on z = 7/8 of the height.",
        erratum: "",
        work: Work::Commands(&[picture(ABOVE_X, "y0-ux", ""), picture(LEVEL, "level-ux", "-level")]),
    },
    Figure {
        number: "3.4",
        source: "u_y below the same wave.",
        here: "u_y on x = 0, and on z = 7/8: u_x turned by 90 degrees.",
        erratum: "",
        work: Work::Commands(&[picture(ABOVE_Y, "x0-uy", ""), picture(LEVEL, "level-uy", "-level")]),
    },
    Figure {
        number: "3.5",
        source: "u_z below the same wave.",
        here: "u_z on y = 0, and on z = 7/8.",
        erratum: "",
        work: Work::Commands(&[picture(ABOVE_X, "y0-uz", ""), picture(LEVEL, "level-uz", "-level")]),
    },
    Figure {
        number: "3.6",
        source: "A strain.",
        here: "ε_xx and ε_zz on y = 0.",
        erratum: "The text does not say which strains figures 3.6 to 3.8 show: here are all six.",
        work: Work::Commands(&[picture(ABOVE_X, "y0-exx", "-exx"), picture(ABOVE_X, "y0-ezz", "-ezz")]),
    },
    Figure {
        number: "3.7",
        source: "A strain.",
        here: "γ_xz on y = 0 and γ_yz on x = 0, engineering strains.",
        erratum: "",
        work: Work::Commands(&[picture(ABOVE_X, "y0-exz", "-exz"), picture(ABOVE_Y, "x0-eyz", "-eyz")]),
    },
    Figure {
        number: "3.8",
        source: "A strain.",
        here: "ε_yy and γ_xy on z = 7/8.",
        erratum: "",
        work: Work::Commands(&[picture(LEVEL, "level-eyy", "-eyy"), picture(LEVEL, "level-exy", "-exy")]),
    },
    Figure {
        number: "3.10",
        source: "u_z below cos(2πx) from (a) the three-dimensional and (b) the two-dimensional solution: equal.",
        here: "(a) on y = L/2, (b) in plane strain.",
        erratum: "",
        work: Work::Commands(&[picture(SPACE, "space-uz", "a"), picture(PLANE, "plane-uz", "b")]),
    },
    Figure {
        number: "3.11",
        source: "u_x, (a) and (b) likewise.",
        here: "The same sections.",
        erratum: "",
        work: Work::Commands(&[picture(SPACE, "space-ux", "a"), picture(PLANE, "plane-ux", "b")]),
    },
    Figure {
        number: "4.1a",
        source: "ũ_x(0, 0), the slowest mode of the punch, against the iteration for several damping factors; the \
                 critical one converges fastest.",
        here: "First wave of u_x (sine, number (1, 0)) of the punch for four factors of the critical damping of eq. \
               4.8, and the uniform mode (0, 0) of the free slab, pushed at one point. For the slab factor 1 is best, \
               for the punch, whose held points stiffen the soft modes, 2.",
        erratum: "ũ_x(0, 0) of the punch is zero at every step: u_x is odd about the middle.",
        work: Work::Dampings,
    },
    Figure {
        number: "4.1b",
        source: "u_x/z_m on the line y = L/2 of the surface after n_tot steps, for the same damping factors.",
        here: "The same after 100 steps, and the converged state (broken).",
        erratum: "",
        work: Work::Dampings,
    },
    Figure {
        number: "4.3",
        source: "u_x of the surface under the sticking punch by (a) GFMD and (b) finite elements with the same nodes.",
        here: "Ours, finite elements, difference, as in all comparisons below.",
        erratum: "",
        work: Work::Commands(&[picture(SURFACE, "top-u_x", "")]),
    },
    Figure {
        number: "4.4",
        source: "u_y of the surface, (a) and (b).",
        here: "As figure 4.3.",
        erratum: "",
        work: Work::Commands(&[picture(SURFACE, "top-u_y", "")]),
    },
    Figure {
        number: "4.5",
        source: "u_z of the surface, (a) and (b).",
        here: "As figure 4.3.",
        erratum: "",
        work: Work::Commands(&[picture(SURFACE, "top-u_z", "")]),
    },
    Figure {
        number: "4.6",
        source: "Displacements of GFMD and finite elements in one plot; eq. 4.13 of u_x is about 0.00196.",
        here: "u_x and u_z of both along x through the middle, and our traction.",
        erratum: "",
        work: Work::Commands(&[picture(SURFACE, "top-cut", "")]),
    },
    Figure {
        number: "4.7",
        source: "u_x over the height, (a) and (b), on a plane captioned x/L = 0.5.",
        here: "u_x on y = L/2.",
        erratum: "On x = L/2 u_x vanishes: the thesis must have drawn y = L/2.",
        work: Work::Commands(&[picture(ALONG_X, "along-x-ux", "")]),
    },
    Figure {
        number: "4.8",
        source: "u_y over the height, (a) and (b), on a plane captioned y/L = 0.5.",
        here: "u_y on x = L/2.",
        erratum: "On y = L/2 u_y vanishes likewise.",
        work: Work::Commands(&[picture(ALONG_Y, "along-y-uy", "")]),
    },
    Figure {
        number: "4.9",
        source: "u_z over the height, (a) and (b), on the plane x/L = 0.5.",
        here: "u_z on x = L/2.",
        erratum: "",
        work: Work::Commands(&[picture(ALONG_Y, "along-y-uz", "")]),
    },
    Figure {
        number: "4.10",
        source: "σ_xx on the plane captioned x/L = 0.5, (a) and (b).",
        here: "σ_xx on x = L/2 as captioned, and on y = L/2, in GPa.",
        erratum: "Other captions name x = L/2 for y = L/2: either plane may be drawn.",
        work: Work::Commands(&[picture(ALONG_Y, "along-y-sxx", ""), picture(ALONG_X, "along-x-sxx", "-y")]),
    },
    Figure {
        number: "4.11",
        source: "σ_xz on a plane captioned x/L = 0.5, (a) and (b).",
        here: "σ_xz on y = L/2, in GPa.",
        erratum: "On x = L/2 σ_xz vanishes likewise.",
        work: Work::Commands(&[picture(ALONG_X, "along-x-sxz", "")]),
    },
];
