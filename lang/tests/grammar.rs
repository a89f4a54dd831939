//! The grammar keeps its contract: nothing that nests is read twice, and every repetition makes way.

use pest_meta::ast::{Expr, Rule};
use pest_meta::parser;
use std::collections::{BTreeMap, BTreeSet};

struct Grammar {
    rules: BTreeMap<String, Expr>,
    /// Rules that lead back to themselves.
    nests: BTreeSet<String>,
}

fn grammar() -> Grammar {
    let text = include_str!("../src/grammar.pest");
    let pairs = parser::parse(parser::Rule::grammar_rules, text).unwrap_or_else(|error| panic!("{error}"));
    let rules = parser::consume_rules(pairs).unwrap_or_else(|errors| panic!("{errors:?}"));
    let rules: BTreeMap<String, Expr> = rules.into_iter().map(|Rule { name, expr, .. }| (name, expr)).collect();
    let reach = |start: &str| {
        let mut found = BTreeSet::new();
        let mut open = vec![start.to_string()];
        while let Some(name) = open.pop() {
            let Some(expr) = rules.get(&name) else { continue };
            for name in names(expr) {
                if found.insert(name.clone()) {
                    open.push(name);
                }
            }
        }
        found
    };
    let nests = rules.keys().filter(|name| reach(name).contains(*name)).cloned().collect();
    Grammar { rules, nests }
}

fn parts(expr: &Expr) -> Vec<&Expr> {
    match expr {
        Expr::Seq(a, b) | Expr::Choice(a, b) => vec![a, b],
        Expr::Opt(a) | Expr::Rep(a) | Expr::RepOnce(a) | Expr::PosPred(a) | Expr::NegPred(a) => vec![a],
        Expr::Str(_) | Expr::Range(..) | Expr::Ident(_) => Vec::new(),
        other => panic!("the grammar uses {other:?}, which this test does not know"),
    }
}

fn walk<'a>(expr: &'a Expr, visit: &mut impl FnMut(&'a Expr)) {
    visit(expr);
    for part in parts(expr) {
        walk(part, visit);
    }
}

fn names(expr: &Expr) -> Vec<String> {
    let mut names = Vec::new();
    walk(expr, &mut |part| {
        if let Expr::Ident(name) = part {
            names.push(name.clone());
        }
    });
    names
}

fn sequence<'a>(expr: &'a Expr, into: &mut Vec<&'a Expr>) {
    match expr {
        Expr::Seq(a, b) => {
            sequence(a, into);
            sequence(b, into);
        }
        other => into.push(other),
    }
}

impl Grammar {
    fn nests(&self, expr: &Expr) -> bool {
        names(expr).iter().any(|name| self.nests.contains(name))
    }

    fn cannot_fail(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Str(text) => text.is_empty(),
            Expr::Opt(_) | Expr::Rep(_) => true,
            Expr::Seq(a, b) => self.cannot_fail(a) && self.cannot_fail(b),
            Expr::Choice(a, b) => self.cannot_fail(a) || self.cannot_fail(b),
            // Recursion that cannot fail would have to pass through an alternative that can.
            Expr::Ident(name) if self.nests.contains(name) => false,
            Expr::Ident(name) => self.rules.get(name).is_some_and(|rule| self.cannot_fail(rule)),
            _ => false,
        }
    }

    fn may_be_empty(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Str(text) => text.is_empty(),
            Expr::Opt(_) | Expr::Rep(_) | Expr::PosPred(_) | Expr::NegPred(_) => true,
            Expr::Seq(a, b) => self.may_be_empty(a) && self.may_be_empty(b),
            Expr::Choice(a, b) => self.may_be_empty(a) || self.may_be_empty(b),
            Expr::RepOnce(a) => self.may_be_empty(a),
            // A rule that nests begins with a bracket, a keyword or a name.
            Expr::Ident(name) if self.nests.contains(name) => false,
            Expr::Ident(name) => self.rules.get(name).is_some_and(|rule| self.may_be_empty(rule)),
            _ => false,
        }
    }
}

#[test]
fn nothing_that_nests_is_read_twice() {
    let grammar = grammar();
    assert!(grammar.nests.contains("block") && grammar.nests.contains("val") && !grammar.nests.contains("path"));
    for (name, rule) in &grammar.rules {
        walk(rule, &mut |expr| {
            if let Expr::PosPred(ahead) | Expr::NegPred(ahead) = expr {
                assert!(!grammar.nests(ahead), "`{name}` looks ahead over what nests: {ahead}");
            }
            let mut list = Vec::new();
            sequence(expr, &mut list);
            let after = list.iter().skip_while(|part| !grammar.nests(part)).skip(1);
            for part in after {
                let is_end = matches!(part, Expr::Ident(name) if name == "EOI");
                assert!(is_end || grammar.cannot_fail(part), "`{name}` can fail at `{part}` after what nests");
            }
        });
    }
}

#[test]
fn every_repetition_makes_way() {
    let grammar = grammar();
    for (name, rule) in &grammar.rules {
        walk(rule, &mut |expr| {
            if let Expr::Rep(turn) | Expr::RepOnce(turn) = expr {
                assert!(!grammar.may_be_empty(turn), "`{name}` may repeat nothing: {turn}");
            }
        });
    }
}

#[test]
fn no_recovery_takes_a_brace() {
    let grammar = grammar();
    for name in ["bad_item", "bad_elem"] {
        let mut refused = BTreeSet::new();
        walk(&grammar.rules[name], &mut |expr| {
            if let Expr::NegPred(ahead) = expr {
                walk(ahead, &mut |part| {
                    if let Expr::Str(text) = part {
                        refused.insert(text.clone());
                    }
                });
            }
        });
        assert!(refused.contains("{") && refused.contains("}"), "{name}");
    }
}
