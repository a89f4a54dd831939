//! Values to what a property takes: types, units and ranges.

use std::sync::Arc;

use kinora_scene::{Keys, Spectrum};

use crate::builtin::texture::{Paint, Texture};
use crate::diagnostic::{Applicability, Diagnostic};
use crate::dimension::{Dimension, short, show};
use crate::eval::curve;
use crate::eval::expr::short_text;
use crate::eval::graph::Scalar;
use crate::eval::items::wrong_count;
use crate::eval::machine::{Machine, NodeKind};
use crate::eval::resolve::has_unlike_arms;
use crate::library::is_path;
use crate::schema::{Bare, Check, Choice, Default, Property, Since, Sort, Type};
use crate::source::{FileId, Span};
use crate::suggest::{all_of, any_of, suggest, value_for};
use crate::syntax::ast::{Expr, ExprKind};
use crate::value::{Keyed, NodeId, Number, Through, Value};

/// A value as its property takes it, in SI.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Numbers, truth values, vectors, colours and rotations by components.
    Parts(Vec<Scalar>),
    /// The same, keyframed.
    Keys(Arc<Keys<Vec<f64>>>),
    /// A word of a choice.
    Word(&'static str),
    /// Text.
    Text(Arc<str>),
    /// A node.
    Node(NodeId),
    /// What varies over a surface.
    Texture(Arc<Texture>),
    /// A node or a camera of a model's file, by its path there.
    Inner(NodeId, Arc<str>),
    /// A list of points, pairs or numbers.
    Rows(Arc<Vec<[f64; 3]>>),
}

impl Data {
    /// Whether it changes over time.
    pub fn is_moving(&self) -> bool {
        match self {
            Data::Parts(parts) => parts.iter().any(|part| part.constant().is_none()),
            Data::Keys(_) => true,
            _ => false,
        }
    }

    /// The components, if they are the same at all times.
    pub fn constants(&self) -> Option<Vec<f64>> {
        match self {
            Data::Parts(parts) => parts.iter().map(|part| part.constant()).collect(),
            _ => None,
        }
    }
}

/// Where a value goes to.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// The property.
    pub property: &'static Property,
    /// The kind that has it.
    pub kind: &'static crate::schema::Kind,
    /// The place of the property's name.
    pub name: Span,
    /// What is written.
    pub expr: &'a Expr,
}

impl Site<'_> {
    /// The place of component `index`, where it can be told.
    fn component(&self, index: usize) -> Span {
        match &self.expr.kind {
            ExprKind::Tuple(items) => items.get(index).map_or(self.expr.span, |item| item.span),
            _ => self.expr.span,
        }
    }
}

impl<'a> Machine<'a> {
    /// The value as the property takes it; `None` where that is reported.
    pub fn fit(&mut self, value: &Value, site: &Site<'a>) -> Option<Data> {
        let property = site.property;
        let data = match (value, &property.ty) {
            (Value::Error, _) => return None,
            (Value::Keys(keyed), _) => self.fit_keys(keyed, site)?,
            _ => self.fit_plain(value, site, site.expr.span, true)?,
        };
        let data = self.varied(data, site)?;
        if !property.animatable && data.is_moving() {
            let movable: Vec<&str> =
                site.kind.all().filter(|p| p.animatable && p.since == Since::Now).map(|p| p.name).collect();
            let mut diagnostic = Diagnostic::new("E0608", format!("`{}` cannot change over time", property.name))
                .primary(self.file(), site.name, "the same at all times")
                .label(self.file(), site.expr.span, "changes over time");
            if !movable.is_empty() {
                let list = all_of(movable.iter().copied());
                diagnostic = diagnostic.help(format!("of `{}`, these can: {list}", site.kind.name));
            }
            self.report(diagnostic);
            return None;
        }
        if property.since == Since::Default && !is_default(&data, property) {
            self.later(
                &format!("`{}` of `{}` other than {}", property.name, site.kind.name, default_text(property)),
                site.name,
            );
            return None;
        }
        Some(data)
    }

    /// Keys stay whole where they stand still; else they are a curve that is computed.
    fn fit_keys(&mut self, keyed: &Arc<Keyed>, site: &Site<'a>) -> Option<Data> {
        let (mut rows, mut slopes) = (Vec::with_capacity(keyed.keys.len()), Vec::new());
        let mut failed = false;
        let mut still = !keyed.oklch;
        for key in &keyed.keys {
            let Some(data) = self.fit_plain(&key.value, site, key.span, false) else {
                failed = true;
                continue;
            };
            let Some(row) = data.constants() else {
                failed |= !matches!(data, Data::Parts(_));
                still = false;
                continue;
            };
            if keyed.through == Through::Tangents {
                let level = vec![0.0; row.len()];
                let mut both = [level.clone(), level];
                for (slope, tangent) in both.iter_mut().zip(key.tangents.iter().flat_map(|two| two.iter())) {
                    match self.fit_type(tangent, site, key.span, false) {
                        Some(Data::Parts(parts)) => match parts.iter().map(|part| part.constant()).collect() {
                            Some(parts) => *slope = parts,
                            None => still = false,
                        },
                        _ => failed = true,
                    }
                }
                slopes.push(both);
            }
            rows.push(row);
        }
        if failed {
            return None;
        }
        if still {
            let slopes = (keyed.through == Through::Tangents).then_some(slopes);
            return curve::whole(&mut self.graph, keyed, rows, slopes).map(|keys| Data::Keys(Arc::new(keys)));
        }
        let flat = self.flatten(Value::Keys(keyed.clone()));
        self.fit_plain(&flat, site, site.expr.span, false)
    }

    fn fit_plain(&mut self, value: &Value, site: &Site<'a>, span: Span, whole: bool) -> Option<Data> {
        let data = self.fit_type(value, site, span, whole)?;
        self.check(&data, site, span).then_some(data)
    }

    /// As [`Machine::fit_plain`], whatever its range.
    fn fit_type(&mut self, value: &Value, site: &Site<'a>, span: Span, whole: bool) -> Option<Data> {
        Some(match (&site.property.ty, value) {
            (_, Value::Texture(texture)) => return self.fit_texture(texture, site, span, whole),
            (Type::Number(dimension, bare), Value::Number(number)) => {
                let expr = whole.then_some(site.expr);
                Data::Parts(vec![self.component(number, *dimension, *bare, span, expr, site)?])
            }
            (Type::Count, Value::Number(number)) if number.dimension.is_none() => {
                Data::Parts(vec![self.whole(value, span).filter(|_| number.dimension.is_none())?])
            }
            (Type::Bool, Value::Bool(scalar)) => Data::Parts(vec![*scalar]),
            (Type::Text, Value::Text(text)) => Data::Text(text.clone()),
            (Type::Color, Value::Color(channels)) => Data::Parts(channels.to_vec()),
            (Type::Rotation, Value::Turn(q)) => Data::Parts(q.to_vec()),
            (Type::Scale, Value::Number(number)) => {
                let expr = whole.then_some(site.expr);
                let factor = self.component(number, Dimension::NONE, Bare::Allowed, span, expr, site)?;
                Data::Parts(vec![factor; 3])
            }
            (Type::Scale, Value::Tuple(items)) => {
                self.components(items, 3, (Dimension::NONE, Bare::Allowed), site, span, whole)?
            }
            (Type::Vec3(dimension, bare), Value::Tuple(items)) => {
                self.components(items, 3, (*dimension, *bare), site, span, whole)?
            }
            (Type::Vec2(dimension, bare), Value::Tuple(items)) => {
                self.components(items, 2, (*dimension, *bare), site, span, whole)?
            }
            (Type::Target, Value::Tuple(items)) => {
                self.components(items, 3, (Dimension::LENGTH, Bare::Allowed), site, span, whole)?
            }
            (Type::Counts, Value::Tuple(items)) => {
                if items.len() != 2 {
                    self.wrong_count(2, items.len(), span);
                    return None;
                }
                let mut parts = Vec::new();
                for (i, item) in items.iter().enumerate() {
                    parts.push(self.whole(item, site.component(i))?);
                }
                Data::Parts(parts)
            }
            (Type::Choice(choices), _) => self.choice(value, choices, site, span)?,
            (Type::Node(sort), Value::Node(id)) => {
                let wanted = *sort;
                self.node_of(*id, span, sort.with_article(), |sort| sort == wanted)?
            }
            (Type::Node(Sort::Camera) | Type::Placed | Type::Target, Value::Inner(id, path)) => {
                self.model_of(*id, span)?;
                Data::Inner(*id, path.clone())
            }
            (Type::Placed, Value::Node(id)) => self.node_of(*id, span, "a shape or a group", Sort::is_placed)?,
            (Type::Target, Value::Node(id)) => {
                self.node_of(*id, span, "a point, a shape or a group", Sort::is_placed)?
            }
            (Type::Limits, Value::Range(from, to)) if [from, to].into_iter().all(is_limit) => {
                Data::Parts(vec![from.value, to.value])
            }
            (Type::Drive, Value::Number(number))
                if [Dimension::SPIN, Dimension::SPEED].contains(&number.dimension) || number.is_bare_zero() =>
            {
                Data::Parts(vec![number.value])
            }
            (Type::Points, Value::List(items)) => self.rows(items, 3, Dimension::LENGTH, span)?,
            (Type::Pairs, Value::List(items)) => self.rows(items, 2, Dimension::NONE, span)?,
            (Type::Indices, Value::List(items)) => {
                let mut rows = Vec::with_capacity(items.len());
                for item in items.iter() {
                    match self.whole(item, span)? {
                        Scalar::Const(value) => rows.push([value, 0.0, 0.0]),
                        moving => {
                            self.structure("a mesh's list", moving, span, span);
                            return None;
                        }
                    }
                }
                Data::Rows(Arc::new(rows))
            }
            _ => {
                self.wrong_type(value, site, span, whole);
                return None;
            }
        })
    }

    /// A texture as the property takes it.
    fn fit_texture(&mut self, texture: &Arc<Texture>, site: &Site<'a>, span: Span, whole: bool) -> Option<Data> {
        let (file, property) = (self.file(), site.property);
        if !whole {
            let diagnostic = Diagnostic::new("E0608", "textures cannot change over time")
                .primary(file, span, "a texture among keys")
                .help("mix two materials, and keyframe the amount");
            self.report(diagnostic);
            return None;
        }
        if !property.varies {
            let able: Vec<&str> =
                site.kind.all().filter(|p| p.varies && p.ty != Type::NormalMap).map(|p| p.name).collect();
            let found = texture.with_article();
            let wanted = property.ty.with_article();
            let mut diagnostic = Diagnostic::new("E0301", format!("`{}` cannot be {found}", property.name))
                .primary(file, span, format!("this is {found}"))
                .label(file, site.name, format!("is {wanted}, the same everywhere"));
            if matches!(property.name, "ior" | "attenuation_color") {
                diagnostic = diagnostic.note("it says what the inside is like, and a texture has no inside");
            }
            if !able.is_empty() {
                let list = all_of(able.iter().copied());
                diagnostic = diagnostic.help(format!("of `{}`, these can: {list}", site.kind.name));
            }
            self.report(diagnostic);
            return None;
        }
        match (property.ty, &**texture) {
            // Pictures have no unit; an expression has been fitted to it before it became a texture.
            (Type::Number(dimension, _), _) if !dimension.is_none() && texture.tape().is_none() => {
                let (wanted, found) = (dimension.with_article(), texture.with_article());
                let diagnostic = Diagnostic::new("E0302", format!("expected {wanted}, found {found}"))
                    .primary(file, span, format!("this is {found}, without a unit"))
                    .label(file, site.name, format!("`{}` is {wanted}", property.name))
                    .help("let `color` be the picture: it scales the light");
                self.report(diagnostic);
                return None;
            }
            (Type::NormalMap, Texture::Normal { .. }) => {}
            (Type::NormalMap, Texture::Image(_)) => {
                let diagnostic = Diagnostic::new("E0301", "expected a normal map, found an image")
                    .primary(file, span, "a picture of colours")
                    .help("write `normal_map(..)` instead of `image(..)`");
                self.report(diagnostic);
                return None;
            }
            (Type::NormalMap, _) | (_, Texture::Normal { .. }) => {
                let (wanted, found) = (property.ty.with_article(), texture.with_article());
                let diagnostic = Diagnostic::new("E0301", format!("expected {wanted}, found {found}"))
                    .primary(file, span, format!("this is {found}"))
                    .label(file, site.name, format!("`{}` is {wanted}", property.name));
                self.report(diagnostic);
                return None;
            }
            _ if !self.fits_squares(texture, site) => return None,
            _ => {}
        }
        Some(Data::Texture(texture.clone()))
    }

    /// Whether all squares of a checker are what the property is, and in its range.
    fn fits_squares(&mut self, texture: &Texture, site: &Site<'a>) -> bool {
        let Texture::Checker { squares, .. } = texture else { return true };
        squares.iter().all(|square| match &square.value {
            Paint::Texture(inside)
                if inside.tape().is_some_and(|tape| (tape.outputs.len() == 3) == (site.property.ty == Type::Color)) =>
            {
                true
            }
            Paint::Texture(inside) if inside.tape().is_none() => self.fits_squares(inside, site),
            Paint::Color(parts) if site.property.ty == Type::Color => {
                self.check(&Data::Parts(parts.map(Scalar::Const).to_vec()), site, square.span)
            }
            Paint::Number(number) if site.property.ty != Type::Color => {
                self.check(&Data::Parts(vec![Scalar::Const(*number)]), site, square.span)
            }
            other => {
                let found = match other {
                    Paint::Color(_) => "a colour",
                    Paint::Texture(inside) if inside.tape().is_some_and(|tape| tape.outputs.len() == 3) => "a colour",
                    _ => "a number",
                };
                let wanted = site.property.ty.with_article();
                let code = if site.property.ty == Type::Color { "E0309" } else { "E0301" };
                let file = self.file();
                let diagnostic = Diagnostic::new(code, format!("expected {wanted}, found {found}"))
                    .primary(file, square.span, format!("this is {found}"))
                    .label(file, site.name, format!("`{}` is {wanted}", site.property.name));
                self.report(diagnostic);
                false
            }
        })
    }

    fn wrong_count(&mut self, expected: usize, found: usize, span: Span) {
        let diagnostic = wrong_count(expected, found, self.file(), span);
        self.report(diagnostic);
    }

    fn wrong_type(&mut self, value: &Value, site: &Site<'a>, span: Span, whole: bool) {
        if has_unlike_arms(site.expr) {
            return;
        }
        let found = self.describe(value);
        let wanted = site.property.ty.with_article();
        let file = self.file();
        let code = match (&site.property.ty, value) {
            (Type::Color, _) => "E0309",
            (Type::Count | Type::Scale | Type::Drive, Value::Number(_)) => "E0302",
            _ => "E0301",
        };
        let mut diagnostic = Diagnostic::new(code, format!("expected {wanted}, found {found}"))
            .primary(file, span, format!("this is {found}"))
            .label(file, site.name, format!("`{}` is {wanted}", site.property.name));
        match (&site.property.ty, value) {
            (Type::Color, Value::Number(number)) if number.dimension.is_none() => {
                let text = short_text(self.text(span));
                let grey = format!("srgb({text}, {text}, {text})");
                diagnostic = match whole && number.value.constant().is_some() {
                    true => diagnostic.fix(Applicability::Safe, format!("write `{grey}`"), file, span, grey),
                    false => diagnostic.help("make a colour of it: `srgb(x, x, x)`"),
                };
            }
            (Type::Color, Value::Tuple(items)) if items.len() == 3 => {
                let text = format!("srgb{}", self.text(span));
                let tuple = matches!(site.expr.kind, ExprKind::Tuple(_)) && whole;
                diagnostic = match tuple {
                    true => {
                        diagnostic.fix(Applicability::Maybe, format!("write `{}`", short_text(&text)), file, span, text)
                    }
                    false => diagnostic.help("make a colour of it: `srgb(r, g, b)`"),
                };
            }
            (Type::Color, Value::Text(text)) if whole && colour_in(text).is_some() => {
                let colour = colour_in(text).unwrap_or_default();
                let trust = if colour == &**text { Applicability::Safe } else { Applicability::Maybe };
                diagnostic = diagnostic.fix(trust, format!("write `{colour}`"), file, span, colour);
            }
            (Type::Color, _) => {
                diagnostic =
                    diagnostic.help("colours are written `#d9402b`, `srgb(0.8, 0.2, 0.1)` or `hsv(30deg, 80%, 90%)`");
            }
            (Type::Vec3(..) | Type::Vec2(..), Value::List(_)) if whole && self.text(span).starts_with('[') => {
                let text = self.text(span);
                let written = format!("({})", text.trim_start_matches('[').trim_end_matches(']'));
                let help = format!("write `{}`", short_text(&written));
                diagnostic = diagnostic.fix(Applicability::Maybe, help, file, span, written);
            }
            (Type::Vec3(..), _) => diagnostic = diagnostic.help("vectors are written `(x, y, z)`"),
            (Type::Vec2(..), _) => diagnostic = diagnostic.help("two components are written `(x, y)`"),
            (Type::Counts, _) => diagnostic = diagnostic.help("write width and height: `(1280, 720)`"),
            (Type::Bool, Value::Number(number)) if whole && number.value.constant().is_some() => {
                let written = if number.is_bare_zero() { "false" } else { "true" };
                diagnostic = diagnostic.fix(Applicability::Maybe, format!("write `{written}`"), file, span, written);
            }
            (Type::Node(Sort::Material), Value::Color(_))
                if whole
                    && matches!(site.expr.kind, ExprKind::Color(_) | ExprKind::Call { .. } | ExprKind::Path(_)) =>
            {
                let written = format!("diffuse {{ color: {} }}", self.text(span));
                let help = format!("write `{}`", short_text(&written));
                diagnostic = diagnostic.fix(Applicability::Maybe, help, file, span, written);
            }
            (Type::Node(_) | Type::Placed | Type::Target | Type::Bool, Value::Text(text))
                if whole && is_name(text) && self.text(span).starts_with('"') =>
            {
                let help = format!("names stand without quotes: `{text}`");
                diagnostic = diagnostic.fix(Applicability::Maybe, help, file, span, text.to_string());
            }
            (Type::Limits, _) => {
                diagnostic = diagnostic.help("write `-30deg..90deg` for a hinge, `-10cm..10cm` for a slider");
            }
            (Type::Drive, _) => {
                diagnostic = diagnostic.help("write `90deg/s` for a hinge, `10cm/s` for a slider");
            }
            (Type::Rotation, Value::Number(_)) => {
                diagnostic = diagnostic.help("say about which axis: `rotate_y(90deg)`");
            }
            (Type::Rotation, Value::Tuple(_)) => {
                diagnostic = diagnostic.help("say in which order: `euler(x: 0deg, y: 90deg, z: 0deg)`");
            }
            _ => {}
        }
        self.report(diagnostic);
    }

    fn components(
        &mut self,
        items: &Arc<[Value]>,
        count: usize,
        (dimension, bare): (Dimension, Bare),
        site: &Site<'a>,
        span: Span,
        whole: bool,
    ) -> Option<Data> {
        if items.len() != count {
            self.wrong_count(count, items.len(), span);
            return None;
        }
        let mut parts = Vec::with_capacity(count);
        let (mut failed, mut wrong) = (false, None);
        for (i, item) in items.iter().enumerate() {
            let place = if whole { site.component(i) } else { span };
            match item {
                // The same mistake as that of the component before.
                Value::Number(number) if wrong == Some(number.dimension) && !number.dimension.is_none() => {}
                Value::Number(number) => {
                    let expr = match &site.expr.kind {
                        ExprKind::Tuple(exprs) if whole => exprs.get(i),
                        _ => None,
                    };
                    match self.component(number, dimension, bare, place, expr, site) {
                        Some(part) => parts.push(part),
                        None => (failed, wrong) = (true, Some(number.dimension)),
                    }
                }
                other => {
                    let found = self.describe(other);
                    let wanted = dimension.with_article();
                    let diagnostic = Diagnostic::new("E0301", format!("expected {wanted}, found {found}")).primary(
                        self.file(),
                        place,
                        format!("this is {found}"),
                    );
                    self.report(diagnostic);
                    failed = true;
                }
            }
        }
        (!failed).then_some(Data::Parts(parts))
    }

    /// One number of a property.
    fn component(
        &mut self,
        number: &Number,
        dimension: Dimension,
        bare: Bare,
        span: Span,
        expr: Option<&'a Expr>,
        site: &Site<'a>,
    ) -> Option<Scalar> {
        if number.dimension == dimension || number.is_bare_zero() {
            return Some(number.value);
        }
        if number.dimension.is_none() {
            if bare == Bare::Allowed {
                return Some(number.value);
            }
            match expr {
                Some(expr) => self.needs_unit(dimension, *number, expr.span),
                None => self.needs_unit(dimension, *number, span),
            }
            return None;
        }
        let (wanted, found) = (dimension.with_article(), number.dimension.with_article());
        let is = match site.property.ty {
            Type::Vec3(..) | Type::Vec2(..) | Type::Target => {
                format!("each component of `{}` is {wanted}", site.property.name)
            }
            _ => format!("`{}` is {wanted}", site.property.name),
        };
        let diagnostic = Diagnostic::new("E0302", format!("expected {wanted}, found {found}"))
            .primary(self.file(), span, format!("this is {found}"))
            .label(self.file(), site.name, is);
        let example = match dimension {
            Dimension::LENGTH => Some("30cm"),
            Dimension::ANGLE => Some("40deg"),
            Dimension::TIME => Some("2s"),
            Dimension::POWER => Some("40W"),
            _ => None,
        };
        self.report(match example {
            Some(example) => diagnostic.help(format!("write {wanted}, for example `{example}`")),
            None => diagnostic,
        });
        None
    }

    /// Reports E0304.
    pub fn needs_unit(&mut self, dimension: Dimension, number: Number, span: Span) {
        let diagnostic = self.without_unit(dimension, number, span);
        self.report(diagnostic);
    }

    /// E0304 for a value at a place.
    pub fn without_unit(&self, dimension: Dimension, number: Number, span: Span) -> Diagnostic {
        let (message, unit) = match dimension {
            Dimension::ANGLE => ("angles need a unit".to_string(), "deg".to_string()),
            Dimension::TIME => ("times need a unit".to_string(), "s".to_string()),
            other => (format!("{} needs a unit", other.with_article()), other.unit()),
        };
        let text = self.text(span);
        let literal = text.trim_start_matches('-').starts_with(|digit: char| digit.is_ascii_digit())
            && text.replace('_', "").parse::<f64>().is_ok();
        let mut diagnostic = Diagnostic::new("E0304", message).primary(
            self.file(),
            span,
            match dimension {
                Dimension::ANGLE => "an angle without a unit".into(),
                Dimension::TIME => "a time without a unit".into(),
                other => format!("{} without a unit", other.with_article()),
            },
        );
        diagnostic = match literal {
            true => {
                let file = self.file();
                let unit = match dimension {
                    Dimension::SPIN => "deg/s".to_string(),
                    _ => unit,
                };
                let insert = format!("{text}{unit}");
                diagnostic.fix(Applicability::Maybe, format!("write `{insert}`"), file, span, insert)
            }
            false => diagnostic.help(format!("multiply by `1{unit}`")),
        };
        if let (Dimension::ANGLE, Some(value)) = (dimension, number.value.constant()) {
            diagnostic = diagnostic.note(format!("{} rad = {}deg", short(value), value.to_degrees().round()));
        }
        diagnostic
    }

    fn choice(&mut self, value: &Value, choices: &'static [Choice], site: &Site<'a>, span: Span) -> Option<Data> {
        let Value::Word(word) = value else {
            let found = match (&site.expr.kind, value) {
                (ExprKind::Path(path), _) => format!("`{}`", self.text(path.span)),
                (_, Value::Text(text)) if is_name(text) => {
                    let diagnostic = wrong_word("text", choices, site.property.name).primary(
                        self.file(),
                        span,
                        "words stand without quotes",
                    );
                    let known = choices.iter().find(|choice| choice.name == &**text);
                    let diagnostic = match known {
                        Some(choice) => {
                            let help = format!("write `{}`", choice.name);
                            diagnostic.fix(Applicability::Safe, help, self.file(), span, choice.name)
                        }
                        None => nearest_word(diagnostic, text, choices, self.file(), span),
                    };
                    self.report(diagnostic);
                    return None;
                }
                _ => self.describe(value),
            };
            self.wrong_word(&found, choices, site, span);
            return None;
        };
        match choices.iter().find(|choice| choice.name == *word) {
            Some(choice) if choice.since != Since::Now => {
                self.later(&format!("`{}: {word}` of `{}`", site.property.name, site.kind.name), span);
                None
            }
            Some(choice) => Some(Data::Word(choice.name)),
            None => {
                self.wrong_word(&format!("`{word}`"), choices, site, span);
                None
            }
        }
    }

    /// E0301 for what is not one of a property's words.
    pub fn wrong_word(&mut self, found: &str, choices: &'static [Choice], site: &Site<'a>, span: Span) {
        let diagnostic =
            wrong_word(found, choices, site.property.name).primary(self.file(), span, "not one of its words");
        let diagnostic = nearest_word(diagnostic, found.trim_matches('`'), choices, self.file(), span);
        self.report(diagnostic);
    }

    /// Whether the node is a model, whose file has nodes inside.
    fn model_of(&mut self, id: NodeId, span: Span) -> Option<()> {
        match self.kind_of(id) {
            NodeKind::Schema(kind) if kind.name == "model" => Some(()),
            NodeKind::Unknown => None,
            _ => {
                let place = self.nodes.get(id.0 as usize).map_or(span, |slot| slot.place());
                let diagnostic = Diagnostic::new("E0204", "only a `model` has nodes of a file")
                    .primary(self.file(), span, "a node in a model")
                    .label(self.file(), place, "not a model");
                self.report(diagnostic);
                None
            }
        }
    }

    /// The node, if it can be used so.
    fn node_of(&mut self, id: NodeId, span: Span, wanted: &str, fits: impl Fn(Sort) -> bool) -> Option<Data> {
        let slot = self.nodes.get(id.0 as usize)?;
        let (ast, place) = (slot.ast, slot.place());
        let sort = match self.kind_of(id) {
            NodeKind::Schema(kind) => kind.sort,
            NodeKind::Prefab(_) => Sort::Group,
            NodeKind::Unknown => return None,
        };
        if fits(sort) {
            return Some(Data::Node(id));
        }
        let is = match self.kind_of(id) {
            NodeKind::Prefab(_) => "a prefab",
            _ => sort.with_article(),
        };
        let name = match &ast.name {
            Some(name) => format!("`{}`", name.text),
            None => "this".into(),
        };
        let diagnostic = Diagnostic::new("E0204", format!("{name} is {is}, expected {wanted}"))
            .primary(self.file(), span, format!("expected {wanted}"))
            .label(self.file(), place, format!("{is}, declared here"));
        self.report(diagnostic);
        None
    }

    fn rows(&mut self, items: &Arc<[Value]>, count: usize, dimension: Dimension, span: Span) -> Option<Data> {
        let mut rows = Vec::with_capacity(items.len());
        for item in items.iter() {
            let Some(numbers) = item.numbers() else {
                let found = self.describe(item);
                let diagnostic =
                    Diagnostic::new("E0301", format!("expected a vector of {count} components, found {found}"))
                        .primary(self.file(), span, "in this list");
                self.report(diagnostic);
                return None;
            };
            if numbers.len() != count {
                self.wrong_count(count, numbers.len(), span);
                return None;
            }
            let mut row = [0.0; 3];
            for (to, number) in row.iter_mut().zip(&numbers) {
                if !number.dimension.is_none() && number.dimension != dimension {
                    let (wanted, found) = (dimension.with_article(), number.dimension.with_article());
                    let diagnostic = Diagnostic::new("E0302", format!("expected {wanted}, found {found}")).primary(
                        self.file(),
                        span,
                        "in this list",
                    );
                    self.report(diagnostic);
                    return None;
                }
                match number.value {
                    Scalar::Const(value) => *to = value,
                    moving => {
                        self.structure("a mesh's list", moving, span, span);
                        return None;
                    }
                }
            }
            rows.push(row);
        }
        Some(Data::Rows(Arc::new(rows)))
    }

    /// Whether every known number is finite and in its range.
    fn check(&mut self, data: &Data, site: &Site<'a>, span: Span) -> bool {
        let parts = match data {
            Data::Parts(parts) => parts,
            Data::Text(text) if site.property.check == Check::Spectrum => return self.spectrum(text, span),
            _ => return true,
        };
        for (i, part) in parts.iter().enumerate() {
            let Some(value) = part.constant() else { continue };
            if !value.is_finite() {
                let name = match (parts.len(), "xyzw".get(i..i + 1), &site.property.ty) {
                    (1, _, _) | (_, None, _) => site.property.name.to_string(),
                    (_, _, Type::Color) => format!("{}.{}", site.property.name, ["r", "g", "b"].get(i).unwrap_or(&"r")),
                    (_, Some(letter), _) => format!("{}.{letter}", site.property.name),
                };
                let what = if value.is_nan() { "NaN" } else { "infinite" };
                let place = if parts.len() > 1 && span == site.expr.span { site.component(i) } else { span };
                let mut diagnostic = Diagnostic::new("E0403", format!("`{name}` is not a finite number ({what})"))
                    .primary(self.file(), place, format!("this comes to {what}"));
                if let Some(origin) = self.not_finite {
                    let line = self.source.line(origin.start);
                    let text = short_text(self.text(origin));
                    diagnostic = diagnostic.note(format!("`{text}` on {line} is not a finite number"));
                }
                self.report(diagnostic);
                return false;
            }
        }
        match self.range(parts, site) {
            None => true,
            Some((code, message, index, help)) => {
                let place = match parts.len() {
                    _ if site.property.check == Check::Direction => span,
                    1 => span,
                    _ if span == site.expr.span => site.component(index),
                    _ => span,
                };
                let value = parts.get(index).and_then(|part| part.constant()).unwrap_or(0.0);
                let dimension = match site.property.ty {
                    Type::Number(dimension, _) | Type::Vec3(dimension, _) | Type::Vec2(dimension, _) => dimension,
                    _ => Dimension::NONE,
                };
                let verb = match site.property.ty {
                    Type::Color => {
                        ["its red is", "its green is", "its blue is"].get(index).copied().unwrap_or("this is")
                    }
                    _ => "this is",
                };
                let label = self.computed(verb, value, dimension, place);
                let mut diagnostic = Diagnostic::new(code, message).primary(self.file(), place, label);
                // There the label is about the call that led there.
                if is_path(&self.source.source(place.start).name) {
                    let text = short_text(self.text(place));
                    diagnostic = diagnostic.note(format!("`{text}` is {}", show(value, dimension)));
                }
                if let Some(bytes) = self.bytes(site, span) {
                    let file = self.file();
                    let text = format!("channels go from 0 to 1: write `{bytes}`");
                    diagnostic = diagnostic.fix(Applicability::Maybe, text, file, span, bytes);
                } else if !help.is_empty() {
                    diagnostic = diagnostic.help(help);
                }
                self.report(diagnostic);
                false
            }
        }
    }

    /// `srgb(255, 128, 0)` as `#ff8000`, where that is what stands at the place.
    fn bytes(&self, site: &Site<'a>, span: Span) -> Option<String> {
        let ExprKind::Call { callee, args } = &site.expr.kind else { return None };
        if site.property.ty != Type::Color || span != site.expr.span || self.text(callee.span) != "srgb" {
            return None;
        }
        let mut written = String::from("#");
        for arg in args {
            let ExprKind::Number(number) = &arg.value.kind else { return None };
            let byte = u8::try_from(number.int?).ok()?;
            written.push_str(&format!("{byte:02x}"));
        }
        (args.len() == 3).then_some(written)
    }

    /// Whether there are measurements of the metal; E0203.
    fn spectrum(&mut self, symbol: &str, span: Span) -> bool {
        if Spectrum::find(symbol).is_some() {
            return true;
        }
        let known = || Spectrum::ALL.iter().map(|metal| metal.symbol());
        let file = self.file();
        let diagnostic = Diagnostic::new("E0203", format!("no measured metal `{}`", short_text(symbol)))
            .primary(file, span, "not known by this symbol")
            .help(format!("there are {}", all_of(known())));
        let diagnostic = match (suggest(symbol, known()).first(), self.text(span).starts_with('"')) {
            (Some(near), true) => {
                let text = format!("\"{near}\"");
                diagnostic.fix(Applicability::Safe, format!("write `{text}`"), file, span, text)
            }
            (Some(near), false) => diagnostic.help(format!("did you mean `\"{near}\"`?")),
            (None, _) => diagnostic,
        };
        self.report(diagnostic);
        false
    }

    /// What is out of range: code, message, component and help.
    fn range(&self, parts: &[Scalar], site: &Site<'a>) -> Option<(&'static str, String, usize, String)> {
        let name = site.property.name;
        let find = |bad: &dyn Fn(f64) -> bool| parts.iter().position(|part| part.constant().is_some_and(bad));
        let all_zero = || parts.iter().all(|part| *part == Scalar::Const(0.0));
        let row = |code, message: String, index, help: &str| Some((code, message, index, help.to_string()));
        match site.property.check {
            Check::Any | Check::Spectrum => None,
            Check::Above0 => {
                let index = find(&|v| v <= 0.0)?;
                row("E0401", format!("{name} must be greater than 0"), index, "")
            }
            Check::AtLeast0 => {
                let index = find(&|v| v < 0.0)?;
                row("E0401", format!("{name} must be at least 0"), index, "")
            }
            Check::Mass => {
                let index = find(&|v| v <= 0.0)?;
                row(
                    "E0901",
                    format!("{name} must be greater than 0"),
                    index,
                    "write `kind: fixed` for immovable things",
                )
            }
            Check::Within(low, high) => {
                let index = find(&|v| v < low as f64 || v > high as f64)?;
                row("E0401", format!("{name} must be within {low}..{high}"), index, "")
            }
            Check::Ratio => {
                let index = find(&|v| !(0.0..=1.0).contains(&v))?;
                let value = parts.get(index)?.constant()?;
                let help = match (2.0..=100.0).contains(&value) {
                    true => format!("did you mean `{}%`?", short(value)),
                    false => "0 is none of it, 1 all of it".into(),
                };
                row("E0407", format!("{name} must be within 0..1"), index, &help)
            }
            Check::Reflectance => {
                if let Some(index) = find(&|v| v < 0.0) {
                    return row("E0401", format!("{name} must be at least 0"), index, "");
                }
                let index = find(&|v| v > 1.0 + 1e-9)?;
                row(
                    "E0407",
                    format!("{name} must be within 0..1; reflectance above 1 creates light"),
                    index,
                    "use an `emitter` for brightness",
                )
            }
            Check::NotZero => {
                let index = find(&|v| v == 0.0)?;
                row("E0404", format!("{name} must not be 0"), index, "use `visible: false` to hide it")
            }
            Check::Ior => {
                let index = find(&|v| v < 1.0)?;
                let bubble = "to model an inner air bubble use `ior: 1` inside";
                let help = if site.kind.name == "dielectric" { bubble } else { "" };
                row("E0406", format!("{name} must be at least 1"), index, help)
            }
            Check::Fov => {
                if let Some(index) = find(&|v| v <= 0.0) {
                    return row("E0408", "field of view must be between 0 and 180deg".into(), index, "");
                }
                let index = find(&|v| v > std::f64::consts::TAU + 1e-9)?;
                row("E0408", "field of view must be at most 360deg".into(), index, "")
            }
            Check::Blades => {
                let index = find(&|v| v != 0.0 && !(3.0..=65_535.0).contains(&v))?;
                row("E0401", format!("{name} must be 0 or within 3..65535"), index, "0 is a round lens")
            }
            Check::Shutter => {
                let index = find(&|v| !(0.0..=std::f64::consts::TAU + 1e-9).contains(&v))?;
                row("E0401", format!("{name} must be within 0deg..360deg"), index, "")
            }
            Check::Disc => {
                let index = find(&|v| !(0.0..std::f64::consts::PI).contains(&v))?;
                row("E0401", format!("{name} must be at least 0deg and below 180deg"), index, "")
            }
            Check::Cone => {
                let index = find(&|v| v <= 0.0 || v > std::f64::consts::TAU + 1e-9)?;
                row("E0401", format!("{name} must be above 0deg and at most 360deg"), index, "")
            }
            Check::Resolution => {
                let index = find(&|v| !(1.0..=16384.0).contains(&v))?;
                row("E0411", "resolution must be 1..16384 per side".into(), index, "")
            }
            Check::Direction if all_zero() => {
                row("E0405", "direction has zero length".into(), 0, "for example `(0, 1, 0)`")
            }
            Check::Direction => None,
        }
    }
}

/// Whether a text could be a name.
fn is_name(text: &str) -> bool {
    let letter = |letter: char| letter.is_alphanumeric() || letter == '_';
    text.starts_with(char::is_alphabetic) && text.chars().all(letter) && text.len() < 64
}

/// The colour that a text says.
fn colour_in(text: &str) -> Option<&str> {
    let digits = text.strip_prefix('#').filter(|digits| matches!(digits.len(), 3 | 6 | 8));
    match digits {
        Some(digits) => digits.bytes().all(|digit| digit.is_ascii_hexdigit()).then_some(text),
        None => value_for(text).filter(|value| value.starts_with('#')),
    }
}

/// Whether a number may bound a way or an angle; lengths need no unit.
fn is_limit(number: &Number) -> bool {
    [Dimension::ANGLE, Dimension::LENGTH, Dimension::NONE].contains(&number.dimension)
}

/// E0301 for a word that a property does not take.
pub fn wrong_word(found: &str, choices: &'static [Choice], property: &str) -> Diagnostic {
    let list = any_of(choices.iter().map(|choice| choice.name));
    Diagnostic::new("E0301", format!("expected {list}, found {found}"))
        .note(format!("`{property}` is one of these words"))
}

/// Adds the word that was probably meant.
pub fn nearest_word(
    diagnostic: Diagnostic,
    found: &str,
    choices: &'static [Choice],
    file: FileId,
    span: Span,
) -> Diagnostic {
    let near = suggest(found, choices.iter().map(|choice| choice.name)).first().copied();
    let Some(choice) = choices.iter().find(|choice| Some(choice.name) == near) else { return diagnostic };
    // A word that is answered with "not yet" would put one error in place of the other.
    let trust = if choice.since == Since::Now { Applicability::Safe } else { Applicability::Maybe };
    diagnostic.fix(trust, format!("write `{}`", choice.name), file, span, choice.name)
}

fn is_default(data: &Data, property: &Property) -> bool {
    match (data, property.default) {
        (Data::Parts(parts), Default::Number(value)) => parts.iter().all(|part| *part == Scalar::Const(value)),
        (Data::Parts(parts), Default::Two(two)) => {
            parts.iter().zip(two).all(|(part, value)| *part == Scalar::Const(value))
        }
        (Data::Parts(parts), Default::Bool(value)) => parts.first() == Some(&Scalar::Const(f64::from(u8::from(value)))),
        (Data::Word(word), Default::Word(default)) => *word == default,
        _ => false,
    }
}

fn default_text(property: &Property) -> String {
    match property.default {
        Default::Number(value) => short(value),
        Default::Two([a, b]) => format!("({}, {})", short(a), short(b)),
        Default::Bool(value) => value.to_string(),
        Default::Word(word) => word.into(),
        _ => "its default".into(),
    }
}
