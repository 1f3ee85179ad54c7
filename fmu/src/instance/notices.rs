//! Warnings of a run: given once, when their condition begins to hold.

use super::Instance;
use super::record::Record;
use crate::failure::Failure;

impl Instance {
    /// Warns of start values that differ from their defaults without effect, or are hardly meant.
    pub(super) fn tell_start_values(&self) {
        if !self.log.takes_warnings() {
            return;
        }
        let (table, Record { parameters, inputs, .. }) = (&self.layout.table, &self.record);
        for warning in table.idle(parameters, inputs).iter().chain(&table.doubts(parameters)) {
            self.log.warning(warning);
        }
    }

    /// Warns of unusual conditions that are new since the last call.
    pub(super) fn tell_notices(&mut self) -> Result<(), Failure> {
        let notices = self.run.notices(&self.layout, &self.record)?;
        // As a rule there are none, and were none.
        if notices.iter().chain(&self.notices).all(Option::is_none) {
            return Ok(());
        }
        for (known, notice) in self.notices.iter().zip(&notices) {
            if let (None, Some(notice)) = (known, notice) {
                let variable = self.layout.table.find(notice.variable).map(|entry| entry.variable);
                let hint = variable.and_then(|variable| variable.meant_beyond(notice.value)).unwrap_or_default();
                self.log.warning(&format!("{notice}{hint}"));
            }
        }
        self.notices = notices;
        Ok(())
    }
}
