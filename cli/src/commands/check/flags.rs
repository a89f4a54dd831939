//! What `check` alone can be told.

use clap::ValueEnum;
use kinora_lang::diagnostic::Applicability;

/// How findings are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// With the lines they are about, on stderr
    Full,
    /// path:line:col: error[E0201]: message, on stderr
    Short,
    /// An array of records, on stdout
    Json,
    /// A record a line, on stdout
    Jsonl,
    /// SARIF 2.1.0, for code scanning, on stdout
    Sarif,
    /// Annotations of GitHub's workflows, on stdout
    Github,
    /// A code quality report of GitLab, on stdout
    Gitlab,
    /// A test report in JUnit's XML, on stdout
    Junit,
}

/// Which fixes are applied.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Fix {
    /// Those that mean what was meant
    Safe,
    /// Those too that likely do
    Maybe,
}

impl Fix {
    pub fn least(self) -> Applicability {
        match self {
            Fix::Safe => Applicability::Safe,
            Fix::Maybe => Applicability::Maybe,
        }
    }
}

/// Which frames are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    All,
    Ends,
    /// So many, the ends among them.
    Evenly(usize),
}

impl Frames {
    pub fn parse(text: &str) -> Result<Frames, String> {
        match text {
            "all" => Ok(Frames::All),
            "ends" => Ok(Frames::Ends),
            number => match number.parse() {
                Ok(count) if count >= 2 => Ok(Frames::Evenly(count)),
                _ => Err("write `all`, `ends` or a number from 2".into()),
            },
        }
    }
}
