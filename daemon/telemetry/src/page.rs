//! A page of metrics in the text format of Prometheus.

use std::fmt::Write as _;

/// The page. Samples are grouped by name, because Prometheus requires those of one name to be
/// adjacent.
#[derive(Debug, Default)]
pub struct Page {
    families: indexmap::IndexMap<String, String>,
}

impl Page {
    /// Adds a sample of a family, which is described once.
    pub fn add(&mut self, name: &str, kind: &str, help: &str, labels: &[(&str, &str)], value: f64) {
        let family = self.family(name, kind, help);
        sample(family, name, labels, value);
    }

    /// Adds a summary: values by quantile, their sum and count.
    pub fn summary(
        &mut self,
        name: &str,
        help: &str,
        labels: &[(&str, &str)],
        quantiles: &[(&str, f64)],
        (sum, count): (f64, f64),
    ) {
        let family = self.family(name, "summary", help);
        for (quantile, value) in quantiles {
            let labels = [labels, &[("quantile", *quantile)]].concat();
            sample(family, name, &labels, *value);
        }
        sample(family, &format!("{name}_sum"), labels, sum);
        sample(family, &format!("{name}_count"), labels, count);
    }

    fn family(&mut self, name: &str, kind: &str, help: &str) -> &mut String {
        self.families
            .entry(name.to_owned())
            .or_insert_with(|| format!("# HELP {name} {help}\n# TYPE {name} {kind}\n"))
    }

    /// Adds the page of a cell: each sample with the cell as its first label.
    pub fn join(&mut self, cell: &str, page: &str) {
        let mut family = String::new();
        for line in page.lines() {
            if let Some(about) = line.strip_prefix("# HELP ") {
                family = about.split(' ').next().unwrap_or_default().to_owned();
            }
            let known = self.families.contains_key(&family);
            if line.starts_with("# HELP ") && !known {
                self.families.insert(family.clone(), format!("{line}\n"));
            } else if line.starts_with("# TYPE ") {
                let text = self.families.entry(family.clone()).or_default();
                if text.lines().count() == 1 {
                    text.push_str(&format!("{line}\n"));
                }
            } else if !line.starts_with('#') {
                let labelled = match line.split_once('{') {
                    Some((name, rest)) => format!("{name}{{cell=\"{cell}\",{rest}\n"),
                    None => line.replacen(' ', &format!("{{cell=\"{cell}\"}} "), 1) + "\n",
                };
                self.families.entry(family.clone()).or_default().push_str(&labelled);
            }
        }
    }

    /// The text.
    #[must_use]
    pub fn text(self) -> String {
        self.families.into_values().collect()
    }
}

fn sample(out: &mut String, name: &str, labels: &[(&str, &str)], value: f64) {
    out.push_str(name);
    for (rank, (label, text)) in labels.iter().enumerate() {
        let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        let _ = write!(out, "{}{label}=\"{text}\"", if rank == 0 { '{' } else { ',' });
    }
    let _ = writeln!(out, "{}{value}", if labels.is_empty() { " " } else { "} " });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_cells_are_joined_by_name_with_the_cell_as_a_label() {
        let mut page = Page::default();
        page.add("a_total", "counter", "A.", &[("x", "one")], 1.0);
        let mut far = Page::default();
        far.add("a_total", "counter", "A.", &[("x", "two")], 2.0);
        far.add("b", "gauge", "B.", &[], 0.5);
        page.join("arm", &far.text());
        let text = "# HELP a_total A.\n# TYPE a_total counter\na_total{x=\"one\"} 1\n\
            a_total{cell=\"arm\",x=\"two\"} 2\n# HELP b B.\n# TYPE b gauge\nb{cell=\"arm\"} 0.5\n";
        assert_eq!(page.text(), text);
    }

    #[test]
    fn samples_of_one_name_stand_together_and_labels_are_escaped() {
        let mut page = Page::default();
        page.add("a_total", "counter", "A.", &[("x", "one")], 1.0);
        page.add("b", "gauge", "B.", &[], 0.5);
        page.add("a_total", "counter", "A.", &[("x", "t\"w\\o\n"), ("y", "z")], 2.0);
        let text = "# HELP a_total A.\n# TYPE a_total counter\na_total{x=\"one\"} 1\n\
            a_total{x=\"t\\\"w\\\\o\\n\",y=\"z\"} 2\n# HELP b B.\n# TYPE b gauge\nb 0.5\n";
        assert_eq!(page.text(), text);
    }
}
