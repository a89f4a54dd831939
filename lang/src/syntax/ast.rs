//! The scene as the evaluator reads it: plain owned data with spans, made by [`Tree::file`](super::Tree::file).
//!
//! Nothing is decided here but shape: precedence is resolved, strings are unescaped, numbers are read. Whatever the
//! parser had to report is already a diagnostic of the tree; in its place stands [`ExprKind::Missing`], an absent
//! `Option` or a shorter list, and nothing derived from it should be reported again.
//!
//! Depth is bounded: no chain of accesses from the file down to a leaf passes more than [`MAX_DEPTH`] expressions, so
//! plain recursion over these types is safe. Chains of `+ - * / && ||` are lists, not nests.

use crate::dimension::Dimension;
use crate::source::Span;
use std::sync::Arc;

/// Most expressions inside one another.
pub const MAX_DEPTH: u32 = 512;

/// A name as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    /// The text; of a quoted name what is between the quotes, unescaped.
    pub text: Arc<str>,
    /// The place, quotes included.
    pub span: Span,
    /// Whether it is written as a string: `"Body/Visor"`.
    pub quoted: bool,
}

/// Names joined by `.`: a variable, a module's member or a field. At least one segment.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// The names.
    pub segments: Vec<Name>,
    /// All of it.
    pub span: Span,
}

/// A type: `list<list<float>>` is `["list", "list", "float"]`. At least one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Type {
    /// From the outside in.
    pub names: Vec<Name>,
    /// All of it.
    pub span: Span,
}

/// The text of the `///` lines right above a declaration, without the slashes and one space after them.
pub type Docs = Option<Arc<str>>;

/// A scene file.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    /// In the order of the text.
    pub items: Vec<Item>,
    /// All of the text.
    pub span: Span,
}

/// What may stand at the top of a file or in a block. Which kinds are allowed where is for the evaluator to say.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// `name: value`
    Property(Property),
    /// `kind name like other { ... }`
    Node(Node),
    /// `let name = value`
    Let(LetDecl),
    /// `param name: type = value in range`
    Param(ParamDecl),
    /// `fn name(a, b) -> type { ... }`
    Fn(FnDecl),
    /// `prefab name(a, b) { ... }`
    Prefab(PrefabDecl),
    /// `for i in list { ... }`
    For(ForStmt),
    /// `if condition { ... } else { ... }`
    If(IfStmt),
    /// `return value`
    Return(ReturnStmt),
    /// `import "file" as name`
    Import(ImportDecl),
    /// `lang 1`
    Lang(LangDecl),
    /// A block whose head could not be read (reported): its items are worth checking, but mean nothing.
    Block(Block),
}

impl Item {
    /// The place of the whole item.
    pub fn span(&self) -> Span {
        match self {
            Item::Property(item) => item.span,
            Item::Node(item) => item.span,
            Item::Let(item) => item.span,
            Item::Param(item) => item.span,
            Item::Fn(item) => item.span,
            Item::Prefab(item) => item.span,
            Item::For(item) => item.span,
            Item::If(item) => item.span,
            Item::Return(item) => item.span,
            Item::Import(item) => item.span,
            Item::Lang(item) => item.span,
            Item::Block(item) => item.span,
        }
    }
}

/// `{ ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// In the order of the text.
    pub items: Vec<Item>,
    /// With the braces.
    pub span: Span,
}

/// `name: value` (also `name = value`, which is reported).
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// `///` lines above.
    pub docs: Docs,
    /// The key; may be a keyword, as `in` and `out` of hermite keys.
    pub name: Name,
    /// The value.
    pub value: Expr,
    /// All of it.
    pub span: Span,
}

/// `kind name like other { ... }`, as an item or as a value. An item has a body, a `like` or both.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// `///` lines above.
    pub docs: Docs,
    /// `sphere`, `metals.gold`.
    pub kind: Path,
    /// Absent in values, and where the author left it out.
    pub name: Option<Name>,
    /// What is copied.
    pub like: Option<Expr>,
    /// What is said about it.
    pub body: Option<Block>,
    /// All of it.
    pub span: Span,
}

/// `let name: type = value`
#[derive(Debug, Clone, PartialEq)]
pub struct LetDecl {
    /// `///` lines above.
    pub docs: Docs,
    /// Absent where it is missing.
    pub name: Option<Name>,
    /// The type after `:`.
    pub ty: Option<Type>,
    /// The value.
    pub value: Expr,
    /// All of it.
    pub span: Span,
}

/// `param name: type = value in range`
#[derive(Debug, Clone, PartialEq)]
pub struct ParamDecl {
    /// `///` lines above: shown beside the slider.
    pub docs: Docs,
    /// Absent where it is missing.
    pub name: Option<Name>,
    /// The type after `:`.
    pub ty: Option<Type>,
    /// The default.
    pub value: Expr,
    /// What follows `in`.
    pub range: Option<Expr>,
    /// All of it.
    pub span: Span,
}

/// `fn name(params) -> type { ... }` or `fn name(params) = value`
#[derive(Debug, Clone, PartialEq)]
pub struct FnDecl {
    /// `///` lines above.
    pub docs: Docs,
    /// Absent where it is missing.
    pub name: Option<Name>,
    /// What it takes.
    pub params: Vec<Formal>,
    /// The type after `->`.
    pub result: Option<Type>,
    /// What it does.
    pub body: FnBody,
    /// From `fn` up to the body.
    pub head: Span,
    /// All of it.
    pub span: Span,
}

/// What a function does.
#[derive(Debug, Clone, PartialEq)]
pub enum FnBody {
    /// `{ let .. return .. }`
    Block(Block),
    /// `= value`
    Value(Expr),
    /// Reported.
    Missing,
}

/// `prefab name(params) { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct PrefabDecl {
    /// `///` lines above.
    pub docs: Docs,
    /// Absent where it is missing.
    pub name: Option<Name>,
    /// What it takes.
    pub params: Vec<Formal>,
    /// What it makes; absent where it is missing.
    pub body: Option<Block>,
    /// From `prefab` up to the body.
    pub head: Span,
    /// All of it.
    pub span: Span,
}

/// A parameter of a function or prefab: `name: type = default`.
#[derive(Debug, Clone, PartialEq)]
pub struct Formal {
    /// The name.
    pub name: Name,
    /// The type after `:`.
    pub ty: Option<Type>,
    /// The value if none is given.
    pub default: Option<Expr>,
    /// All of it.
    pub span: Span,
}

/// `for item in list` or `for index, item in list`: the head of a statement and of a comprehension.
#[derive(Debug, Clone, PartialEq)]
pub struct ForHead {
    /// One name (the item) or two (index, item); none where they are missing.
    pub names: Vec<Name>,
    /// What is gone through.
    pub over: Expr,
    /// From `for` to the end of `over`.
    pub span: Span,
}

/// `for i in list { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct ForStmt {
    /// Names and list.
    pub head: ForHead,
    /// Absent where it is missing.
    pub body: Option<Block>,
    /// All of it.
    pub span: Span,
}

/// `if a { ... } else if b { ... } else { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct IfStmt {
    /// Condition and block of `if` and of every `else if`.
    pub arms: Vec<(Expr, Option<Block>)>,
    /// The block of the last `else`.
    pub otherwise: Option<Block>,
    /// All of it.
    pub span: Span,
}

/// `return value`
#[derive(Debug, Clone, PartialEq)]
pub struct ReturnStmt {
    /// The value.
    pub value: Expr,
    /// All of it.
    pub span: Span,
}

/// `import "file" as name` or `import { a, b as c } from "file"`
#[derive(Debug, Clone, PartialEq)]
pub struct ImportDecl {
    /// The file; absent where it is missing.
    pub path: Option<Name>,
    /// The list in braces: name there and name here.
    pub names: Option<Vec<Rename>>,
    /// The name after `as`.
    pub alias: Option<Name>,
    /// All of it.
    pub span: Span,
}

/// `a` or `a as b` in an import.
#[derive(Debug, Clone, PartialEq)]
pub struct Rename {
    /// The name in the other file.
    pub name: Name,
    /// The name in this one, if it differs.
    pub alias: Option<Name>,
}

/// `lang 1`
#[derive(Debug, Clone, PartialEq)]
pub struct LangDecl {
    /// The number; [`ExprKind::Missing`] where there is none.
    pub version: Expr,
    /// All of it.
    pub span: Span,
}

/// A value with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// All of it; of a missing value, the place where it was expected.
    pub span: Span,
}

impl Expr {
    /// Whether something was expected here and reported, so that nothing is known.
    pub fn is_missing(&self) -> bool {
        matches!(self.kind, ExprKind::Missing)
    }
}

/// What a value is.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// Reported already: derive nothing from it.
    Missing,
    /// `9.81m/s^2`
    Number(Number),
    /// `#rgb`, `#rrggbb`, `#rrggbbaa`: red, green, blue, alpha as written (sRGB-encoded), 255 where alpha is absent.
    Color([u8; 4]),
    /// Text, unescaped.
    Str(Arc<str>),
    /// `true`, `false`
    Bool(bool),
    /// `name`, `module.name`, `value.field`
    Path(Path),
    /// `(a, b)`, `()`. Never one component: parentheses round one value are that value.
    Tuple(Vec<Expr>),
    /// `[a, b]`
    List(Vec<Expr>),
    /// `[for i in list if condition: value]`
    Comp(Box<Comp>),
    /// `-a`, `!a`
    Unary {
        /// The operator.
        op: UnaryOp,
        /// Its place.
        op_span: Span,
        /// What it applies to.
        value: Box<Expr>,
    },
    /// `first op value op value ...`: operators of one precedence, applied from the left. `+ -`, `* /`, `&&` and `||`
    /// have one or more steps; `^`, comparisons and `..` always exactly one.
    Binary {
        /// The leftmost operand.
        first: Box<Expr>,
        /// What is done to it, in order; never empty.
        rest: Vec<Step>,
    },
    /// `f(a, name: b)`
    Call {
        /// What is called: nearly always a path.
        callee: Box<Expr>,
        /// The arguments.
        args: Vec<Arg>,
    },
    /// `f(x).y`. Where only names are joined, it is a [`ExprKind::Path`] instead.
    Field {
        /// The value.
        base: Box<Expr>,
        /// The field.
        name: Name,
    },
    /// `a[i]`
    Index {
        /// The list.
        base: Box<Expr>,
        /// Which item.
        index: Box<Expr>,
    },
    /// `diffuse { ... }`, `gold like metal { ... }`
    Node(Box<Node>),
    /// `keys(...) { 0s: a  1s: b ease out_quad }`
    Keys(Box<Keys>),
    /// `if a { x } else { y }`
    If(Box<IfValue>),
}

/// A unit as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// `m/s^2`, `%`.
    pub name: Name,
    /// What a number before it is multiplied by, and what it then measures in SI; `None` where an exponent is too large.
    pub si: Option<(f64, Dimension)>,
    /// How often `f` stands in it: 1 in `24f`, -1 in `m/f`. The factor counts a frame as a second.
    pub frames: i32,
}

/// A number as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// The value before the unit; infinite where it is too large for f64.
    pub value: f64,
    /// The value again, if it has no point, no exponent and fits.
    pub int: Option<i64>,
    /// Whether it is written without point and exponent.
    pub whole: bool,
    /// The unit as written: `m/s^2`, `%`.
    pub unit: Option<Box<Unit>>,
}

/// `-` or `!`
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-`
    Neg,
    /// `!`
    Not,
}

/// An operator between two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BinaryOp {
    /// `..`
    Range,
    /// `||`
    Or,
    /// `&&`
    And,
    /// `==`
    Eq,
    /// `!=`
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// `/`
    Div,
    /// `^`
    Pow,
}

impl BinaryOp {
    /// Whether it compares the size of two values.
    pub fn is_comparison(self) -> bool {
        matches!(self, BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge | BinaryOp::Eq | BinaryOp::Ne)
    }

    /// As written.
    pub fn text(self) -> &'static str {
        match self {
            BinaryOp::Range => "..",
            BinaryOp::Or => "||",
            BinaryOp::And => "&&",
            BinaryOp::Eq => "==",
            BinaryOp::Ne => "!=",
            BinaryOp::Lt => "<",
            BinaryOp::Le => "<=",
            BinaryOp::Gt => ">",
            BinaryOp::Ge => ">=",
            BinaryOp::Add => "+",
            BinaryOp::Sub => "-",
            BinaryOp::Mul => "*",
            BinaryOp::Div => "/",
            BinaryOp::Pow => "^",
        }
    }
}

/// One operator and its right operand.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The operator.
    pub op: BinaryOp,
    /// Its place.
    pub op_span: Span,
    /// The right operand.
    pub value: Expr,
}

/// `value` or `name: value` in a call.
#[derive(Debug, Clone, PartialEq)]
pub struct Arg {
    /// The name, if it is given by name. Plain arguments come first.
    pub name: Option<Name>,
    /// The value.
    pub value: Expr,
    /// All of it.
    pub span: Span,
}

/// `for i in list if condition: value` in a list.
#[derive(Debug, Clone, PartialEq)]
pub struct Comp {
    /// Names and list.
    pub head: ForHead,
    /// Which items to take.
    pub condition: Option<Expr>,
    /// What is made of each.
    pub value: Expr,
}

/// `keys(options) { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Keys {
    /// `interpolate: spline, outside: hold`
    pub args: Vec<Arg>,
    /// In the order of the text.
    pub keys: Vec<Key>,
    /// With the braces; absent where the block is missing.
    pub block: Option<Span>,
}

/// `time: value ease curve`
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Whether the time counts from the previous key: `after 2s:`.
    pub after: bool,
    /// When.
    pub time: Expr,
    /// What is reached then.
    pub value: KeyValue,
    /// How it is approached.
    pub ease: Option<Expr>,
    /// All of it.
    pub span: Span,
}

/// What a key reaches.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyValue {
    /// A value; may be missing.
    Value(Expr),
    /// `{ value: 1, in: 0, out: 2 }` of hermite keys.
    Block(Block),
}

/// `if a { x } else if b { y } else { z }` as a value.
#[derive(Debug, Clone, PartialEq)]
pub struct IfValue {
    /// Condition and value of `if` and of every `else if`.
    pub arms: Vec<(Expr, Expr)>,
    /// The value of the last `else`; missing where there is none (reported).
    pub otherwise: Expr,
}
