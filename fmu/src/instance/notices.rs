//! Warnings of a run: given once, when their condition begins to hold.

use super::Instance;
use crate::failure::Failure;

impl Instance {
    /// Warns of unusual conditions that are new since the last call.
    pub(super) fn tell_notices(&mut self) -> Result<(), Failure> {
        let notices = self.run.notices(&self.layout, &self.record)?;
        // As a rule there are none, and were none.
        if notices.iter().chain(&self.notices).all(Option::is_none) {
            return Ok(());
        }
        for (known, notice) in self.notices.iter().zip(&notices) {
            if let (None, Some(notice)) = (known, notice) {
                self.log.warning(&notice.to_string());
            }
        }
        self.notices = notices;
        Ok(())
    }
}
