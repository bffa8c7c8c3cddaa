//! What the images may take: `firmware/budgets.toml`.

use crate::{JobResult, command};

/// A budget against what was measured.
#[derive(Debug, PartialEq)]
pub struct BudgetLine {
    /// What it is about, as in the file.
    pub of: String,
    /// The resource, with its unit.
    pub resource: &'static str,
    /// What the image takes of it.
    pub measured: u64,
    /// What it may be.
    pub budget: u64,
}

/// The budgets, as the file has them.
pub struct Budgets(toml::Table);

impl Budgets {
    /// Reads `firmware/budgets.toml`.
    pub fn read() -> JobResult<Self> {
        let path = command::root().join("firmware/budgets.toml");
        let text = std::fs::read_to_string(&path)
            .map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        Self::parse(&text)
    }

    fn parse(text: &str) -> JobResult<Self> {
        let table = text.parse::<toml::Table>();
        Ok(Self(
            table.map_err(|e| format!("firmware/budgets.toml: {e}"))?,
        ))
    }

    /// A measured value against its budget. One without a budget is an error: everything measured has one.
    pub fn line(&self, of: &str, resource: &'static str, measured: u64) -> JobResult<BudgetLine> {
        let value = self.0.get(of).and_then(|section| section.get(resource));
        let budget = value
            .and_then(toml::Value::as_integer)
            .and_then(|budget| u64::try_from(budget).ok())
            .ok_or_else(|| {
                format!("firmware/budgets.toml has no number for {resource} in [{of}]")
            })?;
        Ok(BudgetLine {
            of: of.into(),
            resource,
            measured,
            budget,
        })
    }
}

/// Prints the table; an error names what is over its budget.
pub fn enforce(lines: &[BudgetLine]) -> JobResult {
    println!(
        "\n{:<14} {:<24} {:>9} {:>9} {:>9}",
        "what", "resource", "measured", "budget", "left"
    );
    for line in lines {
        println!(
            "{:<14} {:<24} {:>9} {:>9} {:>9}",
            line.of,
            line.resource,
            line.measured,
            line.budget,
            i128::from(line.budget) - i128::from(line.measured)
        );
    }
    let over: Vec<_> = lines
        .iter()
        .filter(|line| line.measured > line.budget)
        .map(|line| {
            format!(
                "{} takes {} of {}, {} allowed",
                line.of, line.measured, line.resource, line.budget
            )
        })
        .collect();
    if over.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "over budget: {}; make it smaller, or change firmware/budgets.toml and say why",
            over.join("; ")
        )
        .into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_over_its_budget_is_named() {
        let budgets = Budgets::parse("[nucleo]\nflash_bytes = 100\n").unwrap();
        let good = budgets.line("nucleo", "flash_bytes", 100).unwrap();
        assert!(enforce(&[good]).is_ok());
        let bad = budgets.line("nucleo", "flash_bytes", 101).unwrap();
        let error = enforce(&[bad]).unwrap_err().to_string();
        assert!(
            error.contains("nucleo takes 101 of flash_bytes, 100 allowed"),
            "{error}"
        );
        let missing = budgets
            .line("nucleo", "ram_bytes", 1)
            .unwrap_err()
            .to_string();
        assert!(missing.contains("ram_bytes in [nucleo]"), "{missing}");
    }

    #[test]
    fn the_file_can_be_read() {
        assert!(Budgets::read().is_ok());
    }
}
