//! curves.svg: one measure over another, each divided by its own scale, as a field draws them: a line for each group of settings, with a reference.

use super::ensemble::EnsembleMean;
use super::file::CurveConfig;
use super::picture::{BLACK, Page, draw_means};
use draw::axis::PlotAxis;

/// Settings of one line, named by their values up to the last comma, with their numbers along x.
type Line<'a> = (String, Vec<(f64, &'a EnsembleMean)>);

/// The picture, a panel for each curve; `None` without curves.
pub fn curves(means: &[EnsembleMean], curves: &[CurveConfig]) -> Option<String> {
    let drawn = curves.iter().map(|curve| (curve, lines(means, curve)));
    let drawn: Vec<(&CurveConfig, Vec<Line>)> = drawn.collect();
    let longest = drawn.iter().map(|(_, lines)| lines.len()).max()?;
    let mut page = Page::new(drawn.len(), longest + 1);
    for (curve, lines) in &drawn {
        let all = || lines.iter().flat_map(|(_, points)| points);
        let known = || curve.reference.iter().flatten();
        let across = all().map(|(x, _)| *x).chain(known().map(|[x, _]| *x));
        let reach = all().flat_map(|(_, of)| of.reach());
        let reach = reach.map(|y| y / curve.y_over);
        let axes = [
            PlotAxis::around(&curve.words[0], across, 8),
            PlotAxis::around(&curve.words[1], reach.chain(known().map(|[_, y]| *y)), 8),
        ];
        page.draw(&axes, |svg, axes| {
            let points = known().map(|[x, y]| axes.at((*x, *y)));
            let style = format!("stroke=\"{BLACK}\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"");
            svg.line(&style, points);
            for (number, (_, points)) in lines.iter().enumerate() {
                draw_means(svg, axes, number, 1.0 / curve.y_over, points, true);
            }
        });
        for (number, (name, _)) in lines.iter().enumerate() {
            page.words_of_line(number, name);
        }
        if let Some(name) = &curve.reference_name {
            page.words(BLACK, &format!("dashed, black: {name}"));
        }
    }
    Some(page.svg())
}

fn lines<'a>(means: &'a [EnsembleMean], curve: &CurveConfig) -> Vec<Line<'a>> {
    let along = |of: &EnsembleMean| {
        let is_it = |x: &&EnsembleMean| x.name == curve.x && x.chosen == of.chosen;
        means.iter().find(is_it).map(|x| x.mean / curve.x_over)
    };
    let mut lines: Vec<Line> = Vec::new();
    for of in means.iter().filter(|of| of.name == curve.y) {
        let Some(x) = along(of) else { continue };
        let values = of.chosen.iter().map(|(_, value)| value.as_str());
        let values = Vec::from_iter(values).join(", ");
        let name = values.rsplit_once(", ").map_or("", |(name, _)| name);
        match lines.iter_mut().find(|(other, _)| other == name) {
            Some((_, points)) => points.push((x, of)),
            None => lines.push((name.into(), vec![(x, of)])),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(name: &str, value: &str, mean: f64) -> EnsembleMean {
        EnsembleMean::single(name, "", vec![(0, value.into())], mean)
    }

    #[test]
    fn a_line_has_the_settings_of_one_name_over_the_other_measure() {
        let means = [
            mean("creepage", "clean, 1", 2e-3),
            mean("creepage", "clean, 2", 4e-3),
            mean("creepage", "free, 1", 4e-3),
            mean("traction", "clean, 1", 0.15),
            mean("traction", "clean, 2", 0.3),
            mean("traction", "free, 1", 0.1),
        ];
        let curve: CurveConfig = toml::from_str(
            "x = \"creepage\"\ny = \"traction\"\nx_over = 2e-3\ny_over = 0.3\nwords = [\"a\", \"b\"]\nreference = [[0.0, 0.0], [2.0, 1.0]]\nreference_name = \"Carter\"",
        )
        .expect("valid");
        let [(clean, points), (free, _)] = &lines(&means, &curve)[..] else {
            panic!("two lines");
        };
        assert_eq!((clean.as_str(), free.as_str()), ("clean", "free"));
        let places: Vec<f64> = points.iter().map(|(x, _)| *x).collect();
        assert_eq!(places, [1.0, 2.0]);
        let svg = curves(&means, std::slice::from_ref(&curve)).expect("a picture");
        assert!(
            svg.contains("Carter") && svg.matches("a4 4 0 1 0-8 0").count() == 3,
            "{svg}"
        );
        assert!(curves(&means, &[]).is_none());
        assert!(curve.check(&["creepage", "traction"]).is_ok());
        let refused = curve.check(&["creepage"]).expect_err("no such measure");
        assert!(refused.contains("`traction` is no measure"), "{refused}");
        let changed = |change: &dyn Fn(&mut CurveConfig)| {
            let mut other = curve.clone();
            change(&mut other);
            other.check(&["creepage", "traction"])
        };
        let wrong: [&dyn Fn(&mut CurveConfig); 5] = [
            &|curve| curve.x_over = 0.0,
            &|curve| curve.reference = None,
            &|curve| curve.reference = Some(vec![]),
            &|curve| curve.reference = Some(vec![[0.1, f64::NAN], [0.2, 0.3]]),
            &|curve| curve.reference_name = None,
        ];
        assert!(wrong.iter().all(|change| changed(change).is_err()));
    }
}
