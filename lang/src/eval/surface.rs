//! What is known at the point of a surface alone: `p`, `p_local`, `uv` and `normal`, and where values of them may go.

use std::sync::Arc;

use kinora_scene::{Point, Program, STEPS, Unfit, VALUES};

use crate::builtin::texture::Texture;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::eval::coerce::{Data, Site};
use crate::eval::expr::spaced;
use crate::eval::graph::{Graph, Scalar};
use crate::eval::machine::{Machine, not_yet};
use crate::schema::{Sort, Type};
use crate::source::{FileId, Span};
use crate::suggest::all_of;
use crate::syntax::words;
use crate::value::Value;

/// The names of what is known of a point, where nothing else has them.
const POINTS: [(&str, Point); 4] =
    [("p", Point::World), ("p_local", Point::Local), ("uv", Point::Uv), ("normal", Point::Normal)];

/// Their names.
pub const POINT_NAMES: [&str; 4] = [POINTS[0].0, POINTS[1].0, POINTS[2].0, POINTS[3].0];

/// Whether a name stands for something at the point of a surface, if for nothing else.
pub fn is_point(name: &str) -> bool {
    POINTS.iter().any(|(known, _)| *known == name)
}

/// What is known of the point of a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Points(u8);

impl Points {
    /// One of them.
    pub fn of(point: Point) -> Points {
        Points(1 << point as u8)
    }

    /// What both hold.
    pub fn and(self, other: Points) -> Points {
        Points(self.0 | other.0)
    }

    /// The argument of a function that becomes an easing: known no sooner than the points of a surface, but not there.
    pub const INPUT: Points = Points(1 << 7);

    /// Whether it is nothing of a surface.
    pub fn is_none(self) -> bool {
        self.0 & !Points::INPUT.0 == 0
    }

    /// Whether it is the argument of an easing.
    pub fn is_input(self) -> bool {
        self.0 == Points::INPUT.0
    }

    /// As a message names them: "`p` and `uv`".
    fn names(self) -> String {
        let has = |(_, point): &&(&str, Point)| self.0 & Points::of(*point).0 != 0;
        all_of(POINTS.iter().filter(has).map(|(name, _)| *name))
    }

    /// "depends on `p`, which is known at a surface only"
    fn label(self) -> String {
        let one = (self.0 & !Points::INPUT.0).count_ones() == 1;
        format!("depends on {}, which {} known at a surface only", self.names(), if one { "is" } else { "are" })
    }
}

/// What a value needs to know of the point of a surface.
pub fn points(graph: &Graph, value: &Value) -> Points {
    match value {
        Value::Number(number) => graph.points(&[number.value]),
        Value::Bool(scalar) => graph.points(&[*scalar]),
        Value::Color(parts) => graph.points(parts),
        Value::Turn(parts) => graph.points(parts),
        Value::Tuple(items) | Value::List(items) => {
            items.iter().map(|item| points(graph, item)).fold(Points::default(), Points::and)
        }
        _ => Points::default(),
    }
}

/// The texture that these parts of a colour or a number make.
///
/// # Errors
/// They are more than is computed at a point.
pub fn texture(graph: &mut Graph, parts: &[Scalar], file: FileId, span: Span) -> Result<Arc<Texture>, Box<Diagnostic>> {
    let tape = graph.tape(parts);
    let too_many = |limit: usize, what: &str| {
        let message = format!("more than {} {what} at a point of a surface", spaced(limit as f64));
        Diagnostic::new("E1004", message).primary(file, span, "computed at every point that is seen")
    };
    let diagnostic = match Program::new(&tape) {
        Ok(_) => return Ok(Arc::new(Texture::Tape(tape))),
        Err(Unfit::Steps) => too_many(STEPS, "operations").help("use fewer octaves, or mix fewer things"),
        Err(Unfit::Values) => {
            too_many(VALUES, "values at once").help("use each value soon after it is made, or mix fewer things")
        }
        Err(Unfit::Rotation) => not_yet("rotations by directions that differ from point to point", file, span)
            .help("turn by an angle: `rotate_y(..)`"),
    };
    Err(Box::new(diagnostic))
}

impl<'a> Machine<'a> {
    /// What the name stands for at the point of a surface.
    pub fn point(&mut self, name: &str) -> Option<Value> {
        let (_, point) = POINTS.iter().find(|(known, _)| *known == name)?;
        let (count, dimension) = match point {
            Point::World | Point::Local => (3, Dimension::LENGTH),
            Point::Uv => (2, Dimension::NONE),
            Point::Normal => (3, Dimension::NONE),
        };
        let parts: Vec<Scalar> = (0..count).map(|part| self.graph.point(*point, part)).collect();
        Some(Value::vector(&parts, dimension))
    }

    /// As the property takes what may differ from point to point: a texture, if it does; E0613.
    pub fn varied(&mut self, data: Data, site: &Site<'a>) -> Option<Data> {
        let Data::Parts(parts) = &data else { return Some(data) };
        let points = self.graph.points(parts);
        if points.is_none() {
            return Some(data);
        }
        let file = self.file();
        if site.property.varies {
            return match texture(&mut self.graph, parts, file, site.expr.span) {
                Ok(texture) => Some(Data::Texture(texture)),
                Err(diagnostic) => {
                    self.report(*diagnostic);
                    None
                }
            };
        }
        let (name, kind) = (site.property.name, site.kind);
        let able: Vec<&str> = kind.all().filter(|p| p.varies && p.ty != Type::NormalMap).map(|p| p.name).collect();
        let diagnostic = Diagnostic::new("E0613", format!("`{name}` cannot differ from point to point"))
            .primary(file, site.expr.span, points.label())
            .label(file, site.name, format!("is {}, the same everywhere", site.property.ty.with_article()));
        let diagnostic = match (able.is_empty(), kind.sort) {
            (false, _) => diagnostic.help(format!("of `{}`, these can: {}", kind.name, all_of(able))),
            (true, Sort::Shape) => diagnostic.help("colours and ratios of its material can"),
            (true, _) => diagnostic.help("colours and ratios of materials can"),
        };
        self.report(diagnostic);
        None
    }

    /// What decides structure depends on `scalar`: on the point of a surface, E0613, or on time, E0601.
    pub fn structure(&mut self, what: &str, scalar: Scalar, span: Span, around: Span) {
        let points = self.graph.points(&[scalar]);
        let (code, on, label) = match points.is_none() {
            true if points.is_input() => ("E0601", "the argument of an easing", "depends on the argument".to_string()),
            true => ("E0601", "time", "depends on time".to_string()),
            false => ("E0613", "the point of a surface", points.label()),
        };
        let message = format!("{what} may not depend on {on}");
        // The clock itself, where it stands there.
        let text = self.text(span);
        let clock = words(text, "time").into_iter().map(|at| (at, 4));
        let clock = clock.chain(words(text, "frame").into_iter().map(|at| (at, 5))).min();
        let span = match clock.filter(|_| on == "time") {
            Some((at, length)) => Span::new(span.start + at as u32, span.start + at as u32 + length),
            None => span,
        };
        let mut diagnostic = Diagnostic::new(code, message).primary(self.file(), span, label);
        if around != span {
            diagnostic = diagnostic.label(self.file(), around, "decides it here");
        }
        let diagnostic = match (what, points.is_none()) {
            ("the number of nodes", true) => diagnostic.help("animate `visible` instead"),
            ("the number of nodes", false) => diagnostic.help("let `opacity` depend on it instead"),
            ("the choice of a material", true) => {
                diagnostic.help("animate how much there is of each: `mix(a, b, amount: ..)`")
            }
            ("the choice of a material", false) => {
                diagnostic.help("mix them: `mix(a, b, amount: if .. { 1 } else { 0 })`")
            }
            ("the choice of an item", false) => diagnostic.help("choose with `if`"),
            ("which `return` is reached", _) => {
                diagnostic.help("return an `if` value: `return if .. { a } else { b }`")
            }
            _ => diagnostic,
        };
        self.report(diagnostic);
    }
}
