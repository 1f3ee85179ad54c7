//! What a direction does to rates and computed variables besides changing the states.

use super::companion::Companion;
use super::difference::{Around, Move};
use super::equations::{At, Equations};
use super::memory::{Dependence, SHARE, shifted};
use super::of::Of;
use super::slopes::{add, any};

impl Companion {
    /// Whether numbers of the memory have slopes, or none.
    pub(super) fn moves_memory(&self) -> bool {
        self.slopes.iter().any(|slopes| any(&slopes.memory))
    }

    /// What a direction does to rates or computed variables besides changing the states, with the numbers of the memory on which
    /// they depend: so many numbers as are found. Not a number where that is one that is rounded.
    ///
    /// Where the memory moves, everything moves together, by differences: at the edge of the play of a valve, which its input has
    /// drawn along, neither has a derivative alone.
    ///
    /// # Errors
    /// Why there is nothing to tell: they depend on another number that has no slope.
    pub(super) fn besides(
        &mut self,
        direction: usize,
        at: At,
        of: Of,
        dependence: &Dependence,
        found: &mut [f64],
    ) -> Result<(), String> {
        let (way, slopes) = (&mut self.ways[direction], &self.slopes[direction].memory);
        if !dependence.matters(slopes) {
            self.known_besides(direction, at, of, found);
            return Ok(());
        }
        let (memory, unknown) = dependence.of(slopes);
        if any(&memory) {
            let here = of.values(self.equations.as_ref(), at);
            let mut movement = Move { time: 0.0, x: self.stillness.clone(), inputs: way.inputs.clone(), memory };
            let (memory, held, scales) = (&self.memory, self.equations.held(), &self.scales[..]);
            let mut around = Around { at, memory, held, scales, spare: self.spare.as_mut() };
            let evaluate = |equations: &dyn Equations, at: At| of.values(equations, at);
            let (slopes, is_bent) = around.plain_slope(&movement, Some(way), &here, &evaluate)?;
            found.copy_from_slice(&slopes);
            if is_bent {
                // A spring that is just at its limit bends by its anchor and by the position, and may not by both together. Where it
                // does, it is on its way across; what one point of a step is worth, the parts of the step are too short to tell.
                movement.x.clone_from(&self.slopes[direction].states);
                let (slopes, is_bent) = around.plain_slope(&movement, Some(way), &here, &evaluate)?;
                if !is_bent {
                    let still = vec![0.0; at.u.len()];
                    of.slopes(self.equations.as_ref(), at, (&movement.x, &still), found);
                    found.iter_mut().zip(slopes).for_each(|(found, all)| *found = all - *found);
                }
            }
        } else {
            self.known_besides(direction, at, of, found);
        }
        dependence.copied(&self.slopes[direction].memory).for_each(|(place, slope)| found[place] += slope);
        for leaf in unknown {
            self.spare.remember(&shifted(&self.memory, SHARE, |other| other == leaf));
            let (moved, here) = (of.values(self.spare.as_ref(), at), of.values(self.equations.as_ref(), at));
            let depends: Vec<bool> = moved.iter().zip(&here).map(|(moved, here)| moved != here).collect();
            if depends.contains(&true) && !self.rounded.contains(&leaf) {
                return Err("they depend on a number of the memory that has no slope".to_owned());
            }
            found.iter_mut().zip(depends).filter(|(_, depends)| *depends).for_each(|(slope, _)| *slope = f64::NAN);
        }
        Ok(())
    }

    /// The same where the memory does not matter.
    fn known_besides(&mut self, direction: usize, at: At, of: Of, found: &mut [f64]) {
        let way = &mut self.ways[direction];
        let equations = way.varied.as_ref().unwrap_or(&self.equations).as_ref();
        if way.varied.is_some() || any(&way.inputs) {
            of.slopes(equations, at, (&self.stillness, &way.inputs), found);
        }
        add(found, way.by_parameter(self.equations.as_ref(), |equations| of.values(equations, at)));
    }
}
