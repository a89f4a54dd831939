//! The kinds of the tree's nodes and tokens: one per rule of the grammar, and the tokens between them.

use super::grammar::Rule;

macro_rules! kinds {
    (nodes { $($node:ident = $node_rule:ident),* $(,)? } tokens { $($token:ident = $token_rule:ident),* $(,)? }
     between { $($gap:ident = $gap_doc:literal),* $(,)? }) => {
        /// What a node or token of the tree is. The first group are nodes, the others tokens.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum SyntaxKind {
            $(#[doc = concat!("Node of the rule `", stringify!($node_rule), "`.")] $node,)*
            $(#[doc = concat!("Token of the rule `", stringify!($token_rule), "`.")] $token,)*
            $(#[doc = $gap_doc] $gap,)*
        }

        impl SyntaxKind {
            /// Whether it is the kind of a node.
            pub fn is_node(self) -> bool {
                matches!(self, $(SyntaxKind::$node)|*)
            }
        }

        /// The kind of a rule's pair; nothing for rules that make no pair.
        pub(super) fn of_rule(rule: Rule) -> Option<SyntaxKind> {
            match rule {
                $(Rule::$node_rule => Some(SyntaxKind::$node),)*
                $(Rule::$token_rule => Some(SyntaxKind::$token),)*
                _ => None,
            }
        }
    };
}

kinds! {
    nodes {
        File = file, OneValue = one_value, Missing = missing, Unclosed = unclosed, NoComma = no_comma, Block = block,
        Property = property, EqProperty = eq_property, Node = node, Like = like, LangDecl = lang_decl,
        ImportDecl = import_decl, Names = names, Rename = rename, ParamDecl = param_decl, LetDecl = let_decl, Ty = ty,
        FnDecl = fn_decl, PrefabDecl = prefab_decl, Params = params, Formal = formal, ForStmt = for_stmt,
        IfStmt = if_stmt, ReturnStmt = return_stmt, Named = named, IfValue = if_value, Arm = arm, Keys = keys,
        KeyBlock = key_block, Key = key, Expr = expr, Field = field, Index = index, Args = args, NamedArg = named_arg,
        Tuple = tuple, List = list, Comp = comp, Number = number,
    }
    tokens {
        ExtraComma = extra_comma, StrayClose = stray_close, BadName = bad_name, Prefix = prefix, Op = op, Path = path,
        Ident = ident, KeyName = key_name, Boolean = boolean, Color = color, Unit = unit, BadUnit = bad_unit,
        String = string, BadString = bad_string, KwLet = kw_let, KwFn = kw_fn, KwPrefab = kw_prefab, KwFor = kw_for,
        KwIn = kw_in, KwIf = kw_if, KwElse = kw_else, KwImport = kw_import, KwFrom = kw_from, KwAs = kw_as,
        KwParam = kw_param, KwReturn = kw_return, KwKeys = kw_keys, KwEase = kw_ease, KwAfter = kw_after,
        KwLike = kw_like, KwLang = kw_lang, BadItem = bad_item, BadElem = bad_elem,
    }
    between {
        Whitespace = "Spaces, tabs and line breaks.",
        LineComment = "`// ...` up to the line's end.",
        DocComment = "`/// ...` up to the line's end.",
        BlockComment = "`/* ... */`; an unclosed one runs to the end of the file.",
        Digits = "A number without its unit.",
        Bom = "The byte order mark at the start of a file.",
        OpenBrace = "`{`", CloseBrace = "`}`", OpenParen = "`(`", CloseParen = "`)`", OpenBracket = "`[`",
        CloseBracket = "`]`", Comma = "`,`", Semicolon = "`;`", Colon = "`:`", Equals = "`=`", Arrow = "`->`",
        Less = "`<`", Greater = "`>`", Dot = "`.`",
        BadText = "Text that was not parsed.",
    }
}

impl SyntaxKind {
    /// Spaces and comments: what has no meaning.
    pub fn is_trivia(self) -> bool {
        use SyntaxKind::*;
        matches!(self, Whitespace | LineComment | DocComment | BlockComment | Bom)
    }

    /// Nodes and tokens that stand for a mistake.
    pub fn is_error(self) -> bool {
        use SyntaxKind::*;
        matches!(
            self,
            Missing
                | Unclosed
                | NoComma
                | EqProperty
                | ExtraComma
                | StrayClose
                | BadName
                | BadUnit
                | BadString
                | BadItem
                | BadElem
                | BadText
        )
    }

    /// Keywords.
    pub fn is_keyword(self) -> bool {
        (SyntaxKind::KwLet..=SyntaxKind::KwLang).contains(&self)
    }

    /// What may stand at the top of a file or in a block.
    pub fn is_item(self) -> bool {
        use SyntaxKind::*;
        matches!(
            self,
            Property
                | EqProperty
                | Node
                | LangDecl
                | ImportDecl
                | ParamDecl
                | LetDecl
                | FnDecl
                | PrefabDecl
                | ForStmt
                | IfStmt
                | ReturnStmt
                | Block
        )
    }

    /// What may stand where a value is expected. A [`SyntaxKind::Path`] is one in an [`SyntaxKind::Expr`] only.
    pub fn is_value(self) -> bool {
        use SyntaxKind::*;
        matches!(self, Missing | Number | Color | String | BadString | Named | Keys | IfValue | Expr)
    }
}
