use std::fmt;

use gfmd_contact::{Boundary, Contact, Solver};
use gfmd_green::{BaseKind, Condition, Ground};
use gfmd_interface::Sequence;
use gfmd_law::LawKind;
use gfmd_medium::Relaxes;

use crate::facts::{Friction, Lower, MovedBase, Support, WearBy};
use crate::grid_error::GridError;
use crate::unknown::Unknown;
use crate::{Spelling, Unusable, Words, key, setting, words};

/// Parts of a problem, which decide what can be combined and which of its numbers have a meaning. The default is a
/// periodic hard wall on a half-space, under loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Kind of load sequence.
    pub sequence: Sequence,
    /// Law across the gap; [`LawKind::HardWall`] for none.
    pub law: LawKind,
    /// True if a hardness limits the pressure.
    pub hardness: bool,
    /// True if the body yields below its surface.
    pub yields: bool,
    /// Limit of the shear, if there is friction.
    pub friction: Option<Friction>,
    /// Surroundings of the surface.
    pub boundary: Boundary,
    /// Unknown components of the displacement.
    pub unknown: Unknown,
    /// True if slopes are not assumed small.
    pub finite_slope: bool,
    /// Rigid surface below the slab, if there is one.
    pub lower: Option<Lower>,
    /// Elastic body.
    pub support: Support,
    /// True if there are layers below the top one.
    pub layers: bool,
    /// Elastic body of the rough surface, if there is one.
    pub second: Option<Support>,
    /// Relaxing moduli of a viscoelastic body.
    pub relaxes: Option<Relaxes>,
    /// Sliding by which the surfaces wear, if they do.
    pub wear: Option<WearBy>,
    /// Motion of the base, if it moves.
    pub moved_base: Option<MovedBase>,
    /// True for a profile, in plane strain.
    pub line: bool,
    /// True if an approach is prescribed instead of a load.
    pub approach: bool,
    /// True if a lateral displacement is prescribed.
    pub lateral: bool,
    /// True if patches, distributions, spectra and the conductance are measured.
    pub statistics: bool,
    /// True if the flow through the gap is computed.
    pub flow: bool,
    /// True if the leak of a fluid is computed from the flow.
    pub leak: bool,
    /// True if the conductance of a gas in the gap is computed.
    pub gas: bool,
    /// True if the conductance is computed for two given conductivities.
    pub conducts: bool,
    /// True if the loads at which the flow stops are computed.
    pub flow_threshold: bool,
    /// Method to find the grid error.
    pub grid_error: GridError,
    /// True if the search is recorded.
    pub history: bool,
    /// True if a run continues an earlier one.
    pub resume: bool,
    /// Number of processes that share the problem.
    pub processes: usize,
}

impl Default for Facts {
    fn default() -> Self {
        Self {
            sequence: Sequence::Loads,
            law: LawKind::HardWall,
            hardness: false,
            yields: false,
            friction: None,
            boundary: Boundary::Periodic,
            unknown: Unknown::Normal,
            finite_slope: false,
            lower: None,
            support: Support::HalfSpace,
            layers: false,
            second: None,
            relaxes: None,
            wear: None,
            moved_base: None,
            line: false,
            approach: false,
            lateral: false,
            statistics: false,
            flow: false,
            leak: false,
            gas: false,
            conducts: false,
            flow_threshold: false,
            grid_error: GridError::Estimate,
            history: false,
            resume: false,
            processes: 1,
        }
    }
}

impl Facts {
    /// Returns true if a law acts across the gap.
    pub fn has_law(&self) -> bool {
        self.law != LawKind::HardWall
    }

    /// Returns true if a law that shears moves all components of the displacement.
    pub fn shears_by_law(&self) -> bool {
        self.sequence == Sequence::Path && self.lateral && self.friction.is_none()
    }

    /// Returns true for a profile on a patch over a half-space. Its displacement grows with the logarithm of the
    /// distance, and counts from points one length of the profile away.
    pub fn is_level_near(&self) -> bool {
        let is_open = self.support.is_open() || self.second.is_some_and(Support::is_open);
        self.boundary == Boundary::Free && self.line && is_open
    }

    /// Returns true if the solver moves all components of the displacement by damped dynamics, as the source does.
    /// Other solvers find the pressure, which gives the lateral displacement.
    pub fn moves_all_by(&self, solver: Solver) -> bool {
        let is_dynamic = solver != Solver::Auto && Contact::ALL_COMPONENTS_SOLVERS.contains(&solver);
        let is_wall = !self.has_law() && !self.hardness && self.boundary == Boundary::Periodic;
        let all =
            self.sequence == Sequence::Loads && self.unknown == Unknown::All && !self.finite_slope && !self.approach;
        is_dynamic && is_wall && all
    }

    /// Returns true if all components of the displacement are unknown.
    pub fn moves_sideways(&self) -> bool {
        self.unknown == Unknown::All || self.finite_slope || self.friction.is_some() || self.lateral
    }

    /// Returns true if the states follow a law across the gap; on a path also for a hard wall that moves all
    /// components, and for any hard wall of a slab between two surfaces.
    pub fn solves_a_law(&self) -> bool {
        let is_solved = self.lower.is_some() || self.shears_by_law();
        self.has_law() || self.sequence == Sequence::Path && is_solved
    }

    /// Returns true for the path of a hard wall without friction that is solved by hard-wall methods.
    pub fn is_wall_on_path(&self) -> bool {
        self.sequence == Sequence::Path && !self.solves_a_law() && self.friction.is_none()
    }
}

/// Option of a part, its value, and its words beside another part.
type Described = (Words, &'static str, Words);

macro_rules! parts {
    ($($(#[$doc:meta])+ $part:ident: $words:expr, $test:expr;)+) => {
        /// Part of a problem that cannot be combined with some others.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Part { $($(#[$doc])+ $part),+ }

        impl Part {
            /// All parts.
            pub const ALL: &[Self] = &[$(Self::$part),+];

            /// Returns true if the problem has the part.
            pub fn is_in(self, facts: &Facts) -> bool {
                match self { $(Self::$part => { let test: fn(&Facts) -> bool = $test; test(facts) })+ }
            }

            fn words(self, facts: &Facts) -> Described {
                match self { $(Self::$part => { let words: fn(&Facts) -> Described = $words; words(facts) })+ }
            }
        }
    };
}

parts! {
    /// Law across the gap.
    Law: |f| (key("law"), f.law.name(), key("law")), |f| f.has_law();
    /// Upper limit of the pressure.
    Hardness: |_| (key("hardness"), "given", key("hardness")), |f| f.hardness;
    /// Body that yields below its surface.
    Yield: |_| (key("yield_stress"), "given", key("yield_stress")), |f| f.yields;
    /// Limit of the shear.
    Friction: |f| match f.friction {
        Some(Friction::Tresca) => (key("shear_strength"), "given", key("shear_strength")),
        _ => (key("friction"), "given", key("friction")),
    }, |f| f.friction.is_some();
    /// Patch that is not periodic.
    Free: |_| (key("boundary"), "free", setting("boundary", "free")), |f| f.boundary == Boundary::Free;
    /// All components unknown.
    All: |_| (key("components"), "all", setting("components", "all")), |f| f.unknown == Unknown::All;
    /// Surface held sideways.
    Held: |_| (key("components"), "held", setting("components", "held")), |f| f.unknown == Unknown::Held;
    /// All components unknown, or the surface held sideways.
    Sideways: |f| Part::Sideways.first(f), |f| Part::Sideways.has_one(f);
    /// Friction, or lateral motion.
    Rubbed: |f| Part::Rubbed.first(f), |f| Part::Rubbed.has_one(f);
    /// Body with more than one layer or face, or a base that moves.
    Composed: |f| Part::Composed.first(f), |f| Part::Composed.has_one(f);
    /// Upper limit of the pressure, or wear.
    Lossy: |f| Part::Lossy.first(f), |f| Part::Lossy.has_one(f);
    /// Flow, or the loads at which it stops.
    Flowing: |f| Part::Flowing.first(f), |f| Part::Flowing.has_one(f);
    /// Law, or gas in the gap.
    AcrossGap: |f| Part::AcrossGap.first(f), |f| Part::AcrossGap.has_one(f);
    /// Base of a slab, other than the rigid one at rest that is bonded to it.
    Based: |f| Part::Based.first(f), |f| Part::Based.has_one(f);
    /// Slopes that are not small.
    FiniteSlope: |_| (key("finite_slope"), "given", key("finite_slope")), |f| f.finite_slope;
    /// Rigid surface below the slab.
    Lower: |f| match f.lower {
        Some(Lower::Seed) => (key("lower_seed"), "given", key("lower_seed")),
        _ => (key("lower_surface"), "given", key("lower_surface")),
    }, |f| f.lower.is_some();
    /// Half-space.
    HalfSpace: |_| (key("height"), "inf", setting("height", "inf")), |f| f.support == Support::HalfSpace;
    /// Body with a known normal compliance only.
    Table: |_| (key("compliance"), "given", key("compliance")), |f| f.support == Support::Table;
    /// Slab without a base that holds it along z.
    Plate: |f| base(f, "free"), |f| f.support.ground().is_some_and(|ground| ground.normal == Condition::Free);
    /// Base that holds a slab along z only.
    Sliding: |f| base(f, "sliding"), |f| f.support.ground() == Some(Ground::SLIDING);
    /// Base other than the rigid one that is bonded to a slab.
    OtherBase: |f| base(f, "given"), |f| matches!(f.support, Support::Slab(base) if base != BaseKind::Bonded);
    /// Half-space as the base of a slab.
    ElasticBase: |_| (key("base"), "half-space", setting("base", "half-space")),
        |f| f.support == Support::Slab(BaseKind::HalfSpace);
    /// Layers, or a half-space, below the top layer.
    Layered: |f| Part::Layered.first(f), |f| Part::Layered.has_one(f);
    /// Second elastic body.
    SecondBody: |_| (key("second_body"), "given", key("second_body")), |f| f.second.is_some();
    /// Layers below the top one.
    Layers: |_| (key("layer"), "given", key("layer")), |f| f.layers;
    /// Viscoelastic body.
    Prony: |_| (key("prony"), "given", key("prony")), |f| f.relaxes.is_some();
    /// Viscoelastic body with a constant bulk modulus.
    Shear: |_| (key("relaxes"), "shear", setting("relaxes", "shear")), |f| f.relaxes == Some(Relaxes::Shear);
    /// Body whose waves, or components, may relax differently: with a constant bulk modulus, or below an elastic one.
    Unlike: |f| match f.relaxes {
        Some(Relaxes::Shear) => Part::Shear.words(f),
        _ => (
            key("second_body"),
            "given",
            words![setting("relaxes", "shear"), ", or ", key("prony"), " and ", key("second_body")],
        ),
    }, |f| f.relaxes == Some(Relaxes::Shear) || f.relaxes.is_some() && f.second.is_some();
    /// Surfaces that wear.
    Wear: |_| (key("coefficient"), "given", "wear".into()), |f| f.wear.is_some();
    /// Surfaces that wear by a prescribed distance.
    WearByDistance: |_| (setting("wear_by", "distance"), "given", "wear by a distance".into()),
        |f| f.wear == Some(WearBy::Distance);
    /// Friction of surfaces that are not moved sideways.
    StillFriction: |f| {
        let (name, ..) = Part::Friction.words(f);
        (name, "given", words!["friction without ", key("lateral")])
    }, |f| f.friction.is_some() && !f.lateral;
    /// Surfaces that wear by their slip.
    WearBySlip: |_| (setting("wear_by", "slip"), "given", setting("wear_by", "slip")),
        |f| f.wear == Some(WearBy::Slip);
    /// Surfaces without friction.
    Frictionless: |_| {
        let neither = words!["neither ", key("friction"), " nor ", key("shear_strength")];
        (key("friction"), "left out", neither)
    }, |f| f.friction.is_none();
    /// Law with a traction along the surface.
    ShearingLaw: |f| (key("law"), f.law.name(), words!["a ", key("law"), " that shears"]), |f| f.law.shears();
    /// Law without a hard wall.
    OpenLaw: |f| (key("law"), f.law.name(), words!["a ", key("law"), " without a wall"]), |f| !f.law.may_have_wall();
    /// Patch on a slab.
    FreeSlab: |_| (key("boundary"), "free", words!["a slab with ", setting("boundary", "free")]),
        |f| f.boundary == Boundary::Free
            && [Some(f.support), f.second].iter().flatten().any(|support| *support != Support::HalfSpace);
    /// Base that moves.
    MovedBase: |f| match f.moved_base {
        Some(MovedBase::Traction) => (key("base_traction"), "given", key("base_traction")),
        _ => (key("base_displacement"), "given", key("base_displacement")),
    }, |f| f.moved_base.is_some();
    /// Body that moves as it relaxes over a moved base: under a traction, or with a changing Poisson's ratio.
    Creeping: |f| match f.relaxes {
        Some(Relaxes::Shear) => Part::Shear.words(f),
        Some(Relaxes::Both) => Part::Prony.words(f),
        None => (
            key("prony"),
            "given",
            words![setting("relaxes", "shear"), ", or ", key("prony"), " and ", key("base_traction")],
        ),
    }, |f| {
        let is_pulled = f.moved_base == Some(MovedBase::Traction);
        f.relaxes == Some(Relaxes::Shear) || f.relaxes.is_some() && is_pulled
    };
    /// Profile.
    Line: |_| (key("dim"), "2", words!["a profile (", setting("dim", 2), ")"]), |f| f.line;
    /// Lateral motion without friction.
    Lateral: |_| {
        let friction = words![key("friction"), " or ", key("shear_strength")];
        (key("lateral"), "given", words![key("lateral"), ", unless there is ", friction])
    },
        |f| f.lateral && f.friction.is_none();
    /// Lateral displacement of a patch.
    FreeSideways: |_| {
        let (free, all) = (setting("boundary", "free"), setting("components", "all"));
        (key("boundary"), "free", words![free, " and friction, ", key("lateral"), " or ", all])
    }, |f| f.boundary == Boundary::Free && f.moves_sideways();
    /// Path.
    Path: |_| ("path".into(), "asked for", "a path".into()), |f| f.sequence == Sequence::Path;
    /// Flow through the gap.
    Flow: |_| (key("flow"), "given", key("flow")), |f| f.flow;
    /// Leak of a fluid.
    Leak: |_| (key("viscosity"), "given", key("viscosity")), |f| f.leak;
    /// Gas in the gap.
    Gas: |_| (key("gas"), "given", key("gas")), |f| f.gas;
    /// Loads at which the flow stops.
    FlowThreshold: |_| (key("flow_threshold"), "given", key("flow_threshold")), |f| f.flow_threshold;
    /// Record of the search.
    History: |_| (key("history"), "given", key("history")), |f| f.history;
    /// Run that continues an earlier one.
    Resume: |_| (key("resume"), "given", key("resume")), |f| f.resume;
}

impl Part {
    /// Returns the parts that this one stands for, if it stands for several.
    pub fn members(self) -> &'static [Self] {
        match self {
            Self::Sideways => &[Self::All, Self::Held],
            Self::Rubbed => &[Self::Friction, Self::Lateral],
            Self::Composed => &[Self::Layers, Self::SecondBody, Self::Lower, Self::MovedBase],
            Self::Lossy => &[Self::Hardness, Self::Wear],
            Self::Flowing => &[Self::Flow, Self::FlowThreshold],
            Self::AcrossGap => &[Self::Law, Self::Gas],
            Self::Layered => &[Self::Layers, Self::ElasticBase],
            Self::Based => &[Self::OtherBase, Self::MovedBase],
            _ => &[],
        }
    }

    /// Returns true if the problem has one of the [members](Self::members).
    fn has_one(self, facts: &Facts) -> bool {
        self.members().iter().any(|member| member.is_in(facts))
    }

    /// Returns the words for the first of the [members](Self::members) that the problem has.
    fn first(self, facts: &Facts) -> Described {
        let mut members = self.members().iter();
        let found = members.find(|member| member.is_in(facts)).or(self.members().first());
        found.map_or_else(|| (Words::default(), "given", Words::default()), |member| member.words(facts))
    }
}

/// Returns the words for a base: its name if the facts have one, else the given `names`.
fn base(facts: &Facts, names: &'static str) -> Described {
    let found = if let Support::Slab(base) = facts.support { base.name() } else { names };
    (key("base"), found, key("base"))
}

/// Rule that refuses one part in combination with another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Refused part.
    pub part: Part,
    /// Other part of the combination.
    pub with: Part,
    /// Values of the refused part that are allowed in the combination.
    pub allowed: &'static str,
    /// Reason.
    pub why: &'static str,
}

const fn rule(part: Part, with: Part, allowed: &'static str, why: &'static str) -> Rule {
    Rule { part, with, allowed, why }
}

/// Reason why a part has no derivatives.
const NOT_IMPLEMENTED: &str = "not implemented";
/// Reason of the rules for a law that moves all components.
const LAW_ALONE: &str = "the law does not say how it shears surfaces that are pressed in or worn";

/// All rules, in the order of lists and messages.
pub const RULES: &[Rule] = {
    use Part::*;
    &[
        rule(HalfSpace, Lower, "finite", "a second surface needs a lower face"),
        rule(Based, Lower, "left out", "the slab is held by the two surfaces alone"),
        rule(FiniteSlope, Lower, "left out", "nothing holds the slab sideways"),
        rule(Free, Lower, "periodic", "nothing holds the slab outside the patch"),
        rule(All, Lower, "normal", "nothing holds the slab sideways"),
        rule(Rubbed, Lower, "left out", "the slip of each face is not known: nothing else holds the slab sideways"),
        rule(Lower, Shear, "left out", "the relaxation of each wave is not known"),
        rule(Yield, Lower, "left out", "the strain above a free lower face is not computed"),
        rule(Gas, Lower, "left out", "each face has a gap of its own, and the slab between them conducts, too"),
        rule(SecondBody, Lower, "left out", "it has one of the two surfaces, and which one is not given"),
        rule(AcrossGap, FiniteSlope, "left out", "where surfaces are steep, the vertical gap is not their distance"),
        rule(Free, FiniteSlope, "periodic", "points move beyond the rim, where no heights are known"),
        rule(Sideways, FiniteSlope, "normal", "the lateral displacement follows from the slopes"),
        rule(SecondBody, FiniteSlope, "left out", "the slope of each body is not known"),
        rule(MovedBase, FiniteSlope, "left out", "the base moves the surface sideways, too"),
        rule(Sideways, Table, "normal", "the normal compliance alone is known"),
        rule(FiniteSlope, Table, "left out", "the normal compliance alone is known"),
        rule(Rubbed, Table, "left out", "the normal compliance alone is known"),
        rule(Prony, Table, "left out", "its moduli are not known"),
        rule(Free, Table, "periodic", "the compliance of waves longer than the cell is not known"),
        rule(Composed, Table, "left out", "the table describes the whole body, or both bodies together, at one face"),
        rule(Held, Free, "normal", "nothing holds the surface outside the patch sideways"),
        rule(Held, SecondBody, "normal", "the relative displacement of two held bodies is not that of one"),
        rule(Held, Rubbed, "normal", "friction, or the law, decides the lateral displacement"),
        rule(Held, Shear, "normal", "the relaxation of each wave is not known"),
        rule(Held, Yield, "normal", "the plastic strain moves the surface sideways"),
        rule(MovedBase, Creeping, "left out", "the surface above the base moves as the body relaxes"),
        rule(
            MovedBase,
            Yield,
            "left out",
            "the stress by the base, which adds to the stress by the contact, is not computed",
        ),
        rule(Lossy, OpenLaw, "left out", "without a wall nothing is pressed in or rubbed off"),
        rule(Friction, ShearingLaw, "left out", "the law has a shear of its own"),
        rule(WearBySlip, Frictionless, "distance", "slip is known with friction only"),
        rule(Lossy, Lateral, "left out", LAW_ALONE),
        rule(Free, MovedBase, "periodic", "the effect of the base is that of a periodic cell"),
        rule(Plate, Free, "bonded, sliding or half-space", "nothing holds the plate far away"),
        rule(Line, FreeSideways, "3", "the lateral displacement of a profile is known up to a constant"),
        rule(Sliding, FreeSideways, "bonded or half-space", "the body has no lateral support"),
        rule(StillFriction, WearByDistance, "left out", "surfaces that slide over a distance slip at all points"),
        rule(Rubbed, Unlike, "left out", "shear and pressure relax differently"),
        rule(Layered, Shear, "left out", "the relaxation of each wave is not known"),
        rule(FreeSlab, Unlike, "periodic", "the relaxation of the patch is not known"),
        rule(Hardness, Yield, "left out", "a hardness stands for the yielding below the surface"),
        rule(Law, Yield, "hard-wall", "with an attraction, a step of a body that yields may have several solutions"),
        rule(Friction, Yield, "left out", "the plastic strain by shear on the surface is not known"),
        rule(Lateral, Yield, "left out", "the plastic strain by shear on the surface is not known"),
        rule(Prony, Yield, "left out", "a body that yields and relaxes is another material"),
        rule(Wear, Yield, "left out", "worn surfaces would take strained material with them"),
        rule(Free, Yield, "periodic", "the strain below the surface is computed in a periodic cell"),
        rule(Table, Yield, "left out", "the strain below the surface needs moduli"),
        rule(Plate, Yield, "bonded, sliding or half-space", "the strain above a free lower face is not computed"),
        rule(Flowing, Line, "left out", "a profile has no flow"),
        rule(History, Resume, "left out", "it records a search from its beginning"),
        rule(FiniteSlope, Path, "left out", "points that move sideways would take their histories with them"),
        rule(All, Path, "normal", "lateral motion and friction make all components unknown"),
        rule(FlowThreshold, Path, "left out", "the load of a path may fall, and the gap close more than once"),
        rule(History, Path, "left out", "it records one search, and a step may take several"),
    ]
};

/// Error: a refused combination of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clash {
    /// Broken rule.
    pub rule: Rule,
    facts: Facts,
}

impl From<Clash> for Unusable {
    fn from(Clash { rule: Rule { part, with, allowed, why }, facts }: Clash) -> Self {
        let ((name, found, _), (.., with)) = (part.words(&facts), with.words(&facts));
        Self::value(name, found, words![allowed, " with ", with]).because(why)
    }
}

impl fmt::Display for Clash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Unusable::from(*self).fmt(f)
    }
}

impl std::error::Error for Clash {}

impl Facts {
    /// Checks the combination of all parts.
    ///
    /// # Errors
    /// Returns the first broken rule.
    pub fn check(&self) -> Result<(), Clash> {
        match RULES.iter().find(|rule| rule.part.is_in(self) && rule.with.is_in(self)) {
            Some(rule) => Err(Clash { rule: *rule, facts: *self }),
            None => Ok(()),
        }
    }
}

/// Parts without derivatives.
const WITHOUT_GRADIENT: [Part; 3] = {
    use Part::*;
    [FiniteSlope, Lower, MovedBase]
};

impl Facts {
    /// Checks that the derivatives of a state are known.
    ///
    /// # Errors
    /// Returns an error that names the first part without derivatives, or several processes.
    pub fn check_gradient(&self) -> Result<(), Unusable> {
        let found = WITHOUT_GRADIENT.into_iter().find(|part| part.is_in(self)).map(|part| part.words(self));
        let several = (self.processes > 1).then(|| ("mpirun".into(), "given", Words::default()));
        found.or(several).map_or(Ok(()), |(name, found, _)| {
            Err(Unusable::value(name, found, "left out for derivatives").because(NOT_IMPLEMENTED))
        })
    }
}

impl Part {
    /// Returns the flag, with its value if it is one of several; the flags of all [members](Self::members).
    pub fn given(self) -> String {
        self.given_among(&|_| true).unwrap_or_default()
    }

    /// Returns the flags as [`given`](Self::given), of the possible parts alone; `None` if none is possible.
    fn given_among(self, is_possible: &dyn Fn(Self) -> bool) -> Option<String> {
        if self.members().is_empty() {
            return is_possible(self).then(|| self.flag());
        }
        let possible = self.members().iter().filter(|member| is_possible(**member));
        let mut flags: Vec<String> = possible.map(|member| member.flag()).collect();
        let last = flags.pop()?;
        Some(if flags.is_empty() { last } else { format!("{} or {last}", flags.join(", ")) })
    }

    fn flag(self) -> String {
        let (name, found, _) = self.words(&Facts::default());
        let flag = name.spelled(Spelling::Flag);
        if self == Self::StillFriction {
            return self.beside(&Facts::default());
        }
        if found == "given" || self == Self::Law { flag } else { format!("{flag} {found}") }
    }

    /// Returns the words for the part beside another one, with flags, if it is possible.
    fn beside_among(self, is_possible: &dyn Fn(Self) -> bool) -> Option<String> {
        match self.members().is_empty() {
            true => is_possible(self).then(|| self.beside(&Facts::default())),
            false => self.given_among(is_possible),
        }
    }

    /// Returns the words for the part beside another one, with flags.
    fn beside(self, facts: &Facts) -> String {
        self.words(facts).2.spelled(Spelling::Flag)
    }

    /// Returns true if loads, or a path, can have the part.
    fn is_of(self, sequence: Sequence) -> bool {
        match sequence {
            Sequence::Loads => !matches!(
                self,
                Self::Friction
                    | Self::Lateral
                    | Self::FreeSideways
                    | Self::Path
                    | Self::Prony
                    | Self::Shear
                    | Self::Wear
                    | Self::Yield
                    | Self::WearByDistance
                    | Self::StillFriction
                    | Self::Creeping
                    | Self::Unlike
                    | Self::WearBySlip
                    | Self::Frictionless
            ),
            Sequence::Path => !RULES.iter().any(|rule| rule.part == self && rule.with == Self::Path),
        }
    }
}

/// Returns the rules of loads, or of a path, by part: the part in words, and the parts that are refused with it.
pub fn rules_of(sequence: Sequence) -> Vec<(String, Vec<String>)> {
    rules_among(|part| part.is_of(sequence))
}

/// Returns the rules of steady sliding, as [`rules_of`] does.
pub fn rules_of_sliding() -> Vec<(String, Vec<String>)> {
    rules_among(|part| OF_SLIDING.contains(&part))
}

/// Parts that steady sliding can have; friction is there whatever relaxes, on a half-space.
const OF_SLIDING: [Part; 11] = {
    use Part::*;
    [Hardness, HalfSpace, Plate, Sliding, OtherBase, ElasticBase, SecondBody, Layers, Prony, Shear, Line]
};

fn rules_among(is_possible: impl Fn(Part) -> bool) -> Vec<(String, Vec<String>)> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for Rule { part, with, .. } in RULES {
        let (Some(part), Some(with)) = (part.given_among(&is_possible), with.beside_among(&is_possible)) else {
            continue;
        };
        let words = format!("no {part}");
        match groups.iter_mut().find(|(other, _)| *other == with) {
            Some((_, all)) => all.push(words),
            None => groups.push((with, vec![words])),
        }
    }
    groups
}

/// Returns the rules as a Markdown table: part, other part, allowed values, reason.
pub fn table() -> String {
    let row = |Rule { part, with, allowed, why }: &Rule| {
        let with = with.beside_among(&|_| true).unwrap_or_default();
        format!("| {} | {with} | {allowed} | {why} |\n", part.given())
    };
    let head = "| given | with | must be | reason |\n|---|---|---|---|\n";
    RULES.iter().filter(|rule| rule.with != Part::Path).fold(head.to_owned(), |table, rule| table + &row(rule))
}
