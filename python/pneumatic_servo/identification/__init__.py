"""Identification: from measured data to a model of the user's own machine.

>>> import pneumatic_servo as ps
>>> found = ps.fit("rig.csv", experiment="rig", law="Stribeck", fit="friction.stribeck.Fc,valve.deadZone",
...                columns="time=t,valveVoltage=u,position=x[mm]")           # doctest: +SKIP
>>> found.to_ssv("rig.ssv")                                                  # doctest: +SKIP
"""

from pneumatic_servo.identification.band import Band
from pneumatic_servo.identification.cross_validation import CrossValidation
from pneumatic_servo.identification.discrimination import Telling
from pneumatic_servo.identification.evidence import Evidence
from pneumatic_servo.identification.experiments import EXPERIMENTS, Options
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.fitting import fit
from pneumatic_servo.identification.laws import Ranking, compare_fits
from pneumatic_servo.identification.planning import Plan, plan
from pneumatic_servo.identification.posterior import Posterior
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.series import Series, fit_series

__all__ = [
    "EXPERIMENTS", "Band", "CrossValidation", "Estimate", "Evidence", "Fit", "Options", "Plan", "Posterior", "Ranking",
    "Series", "Telling", "compare_fits", "fit", "fit_series", "plan",
]  # fmt: skip
