"""The laws of the enumeration, with their defaults, from parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .bristles import BlimanSorine, Dahl, ElastoPlastic, LuGre, RevisedLuGre
from .dry import Ageing, DryFriction
from .hybrid import Law, Stribeck
from .karnopp import Karnopp
from .leuven import Leuven
from .maxwell import GeneralisedMaxwellSlip, MaxwellSlip
from .polito import Polito
from .reset_integrator import ResetIntegrator
from .smooth import (
    cubic_ramp,
    none,
    sine_ramp,
    smooth_coulomb,
    stribeck_regularised,
    transition_regularised,
    velocity_based,
)
from .stick_slip import StickSlipCreep, StickSlipSpring

Settings = Mapping[str, float]


@dataclass(frozen=True)
class Entry:
    """A law of the enumeration: its parameter group, defaults and constructor."""

    group: str
    defaults: Settings
    build: Callable[[Settings], Law]


STRIBECK_DEFAULTS: Settings = {"Fs": 11.0, "Fc": 8.3, "vs": 0.01, "delta": 2.0}
TRANSITION_DEFAULTS: Settings = {"Fs": 11.0, "Fc": 8.3, "vs": 1e-3, "vd": 1e-2, "sigma2": 30.0}


def _steady(p: Settings) -> Stribeck:
    return Stribeck(p["Fs"], p["Fc"], p["vs"], p["delta"])


def _stribeck(p: Settings) -> Law:
    if p["FsInf"] == 0.0 and p["kappaRatio"] == 1.0:
        return DryFriction(p["Fs"], _steady(p), p["sigma2"]).law()
    return Ageing(_steady(p), p["FsInf"], p["gamma"], p["kappaRatio"], p["sigma2"]).law()


LAWS: dict[str, Entry] = {
    "None": Entry("none", {}, lambda p: none()),
    "Coulomb": Entry(
        "coulomb",
        {"Fc": 8.3, "sigma2": 30.0},
        lambda p: DryFriction(p["Fc"], lambda speed: p["Fc"], p["sigma2"]).law(),
    ),
    "CoulombStiction": Entry(
        "coulombStiction",
        {"Fs": 11.0, "Fc": 8.3, "sigma2": 30.0},
        lambda p: DryFriction(p["Fs"], lambda speed: p["Fc"], p["sigma2"]).law(),
    ),
    "SmoothCoulomb": Entry(
        "smoothCoulomb",
        {"Fc": 8.3, "vd": 1e-3, "sigma2": 30.0},
        lambda p: smooth_coulomb(p["Fc"], p["vd"], p["sigma2"]),
    ),
    "VelocityBased": Entry(
        "velocityBased",
        {"Fs": 11.0, "Fc": 8.3, "vs": 0.01, "E": 0.0, "sigma2": 30.0},
        lambda p: velocity_based(p["Fs"], p["Fc"], p["vs"], p["E"], p["sigma2"]),
    ),
    "StribeckRegularised": Entry(
        "stribeckRegularised",
        {**STRIBECK_DEFAULTS, "eps": 1e-3, "sigma2": 30.0},
        lambda p: stribeck_regularised(_steady(p), p["eps"], p["sigma2"]),
    ),
    "Stribeck": Entry(
        "stribeck",
        {**STRIBECK_DEFAULTS, "sigma2": 30.0, "FsInf": 0.0, "gamma": 0.1, "kappaRatio": 1.0},
        _stribeck,
    ),
    "Karnopp": Entry(
        "karnopp",
        {**STRIBECK_DEFAULTS, "DV": 1e-4, "sigma2": 30.0},
        lambda p: Karnopp(_steady(p), p["DV"], p["sigma2"]).law(),
    ),
    "Polito": Entry(
        "polito",
        {
            "Fs": 10.8,
            "Fc1": 7.8,
            "Fc2": 7.8,
            "vs": 0.01,
            "c1": 33.0,
            "c2": 25.0,
            "delta": 2.0,
        },
        lambda p: Polito(p["Fs"], p["Fc1"], p["Fc2"], p["vs"], p["c1"], p["c2"], p["delta"]).law(),
    ),
    "Dahl": Entry(
        "dahl",
        {"Fc": 10.6, "sigma0": 8e6, "n": 1.0, "sigma2": 0.0},
        lambda p: Dahl(p["Fc"], p["sigma0"], p["n"], p["sigma2"]).law(),
    ),
    "ResetIntegrator": Entry(
        "resetIntegrator",
        {"sigma0": 1e6, "z0": 8.3e-6, "a": 0.325, "sigma1": 1000.0, "sigma2": 30.0},
        lambda p: ResetIntegrator(p["sigma0"], p["sigma1"], p["sigma2"], p["z0"], p["a"]).law(),
    ),
    "LuGre": Entry(
        "lugre",
        {**STRIBECK_DEFAULTS, "sigma0": 1e6, "sigma1": 1e3, "sigma2": 30.0, "vd": 1e-2},
        lambda p: LuGre(_steady(p), p["sigma0"], p["sigma1"], p["sigma2"], p["vd"]).law(),
    ),
    "RevisedLuGre": Entry(
        "revisedLuGre",
        {
            **STRIBECK_DEFAULTS,
            "sigma0": 1e6,
            "sigma1": 1e3,
            "sigma2": 30.0,
            "vb": 0.05,
            "tauHp": 0.25,
            "tauHn": 1.0,
            "tauH0": 40.0,
            "v0": 1e-4,
            "vd": 1e-2,
        },
        lambda p: RevisedLuGre(
            *(p[name] for name in ("Fs", "Fc", "vs", "delta", "sigma0", "sigma1", "sigma2")),
            *(p[name] for name in ("vb", "tauHp", "tauHn", "tauH0", "v0", "vd")),
        ).law(),
    ),
    "Leuven": Entry(
        "leuven",
        {
            **STRIBECK_DEFAULTS,
            "n": 1.0,
            "k1": 1.483e6,
            "f1": 5.595,
            "f2": 5.631e5,
            "sigma1": 0.0,
            "sigma2": 30.0,
        },
        lambda p: Leuven(_steady(p), p["n"], p["k1"], p["f1"], p["f2"], p["sigma1"], p["sigma2"]).law(),
    ),
    "GMS": Entry(
        "gms",
        {**STRIBECK_DEFAULTS, "C": 500.0, "sigma2": 30.0},
        lambda p: GeneralisedMaxwellSlip(_steady(p), (4e5, 3e5, 2e5, 1e5), (0.25,) * 4, p["C"], p["sigma2"]).law(),
    ),
    "MaxwellSlip": Entry(
        "maxwellSlip",
        {"sigma2": 30.0},
        lambda p: MaxwellSlip((8e5, 4e5, 2e5, 1e5), (2.075,) * 4, p["sigma2"]).law(),
    ),
    "BlimanSorine": Entry(
        "blimanSorine",
        {"f1": 24.6, "f2": 16.3, "eta": 0.5, "xe": 1e-5, "sigma2": 30.0},
        lambda p: BlimanSorine(p["f1"], p["f2"], p["eta"], p["xe"], p["sigma2"]).law(),
    ),
    "ElastoPlastic": Entry(
        "elastoPlastic",
        {
            **STRIBECK_DEFAULTS,
            "sigma0": 1e6,
            "sigma1": 1000.0,
            "sigma2": 30.0,
            "zbaRatio": 0.7,
        },
        lambda p: ElastoPlastic(_steady(p), p["sigma0"], p["sigma1"], p["sigma2"], p["zbaRatio"]).law(),
    ),
    "StepRegularised": Entry(
        "stepRegularised",
        TRANSITION_DEFAULTS,
        lambda p: transition_regularised(cubic_ramp, p["Fs"], p["Fc"], p["vs"], p["vd"], p["sigma2"]),
    ),
    "SineRegularised": Entry(
        "sineRegularised",
        TRANSITION_DEFAULTS,
        lambda p: transition_regularised(sine_ramp, p["Fs"], p["Fc"], p["vs"], p["vd"], p["sigma2"]),
    ),
    "StickSlipSpring": Entry(
        "stickSlipSpring",
        {"Fs": 11.0, "Fc": 8.3, "k": 1e5, "d": 300.0, "sigma2": 30.0},
        lambda p: StickSlipSpring(p["Fs"], p["Fc"], p["k"], p["d"], p["sigma2"]).law(),
    ),
    "StickSlipCreep": Entry(
        "stickSlipCreep",
        {
            "Fs": 11.0,
            "Fc": 8.3,
            "Delta": 1e-5,
            "vs": 1e-3,
            "vd": 1e-2,
            "sigma1": 1000.0,
            "sigma2": 30.0,
        },
        lambda p: StickSlipCreep(p["Fs"], p["Fc"], p["Delta"], p["vs"], p["vd"], p["sigma1"], p["sigma2"]).law(),
    ),
}
