"""Controllers with a state of their own for each run: copies of objects, closures, partial functions; or factories."""

from __future__ import annotations

import copy
import functools
import inspect
import types
from reprlib import repr as shortened
from typing import Any

SHARED = (types.ModuleType, type, types.BuiltinFunctionType)
"""Kinds of values without a state that a run could change."""


def fresh(controller: Any) -> Any:
    """Return a controller for one run, whose state no other run sees.

    A function that needs no arguments, and takes no two, is a factory: it is called, and what it returns is the
    controller. Functions are copied with the variables that they close over, their defaults and their attributes;
    bound methods with their object; objects by ``copy.deepcopy``. Global variables are shared by all runs.

    Raises
    ------
    TypeError
        When something that the controller keeps cannot be copied; the message names it.
    """
    if is_factory(controller):
        made = controller()
        if not callable(made) or is_factory(made):
            raise TypeError(
                f"controller: a function without parameters makes a controller for each run, and this one made "
                f"{shortened(made)}; a controller takes the time and the outputs"
            )
        return made
    return _copied(controller, {}, "controller")


def is_factory(controller: Any) -> bool:
    """Tell whether a callable can be called without arguments, and not with time and outputs: it makes controllers."""
    if not callable(controller):
        return False
    try:
        signature = inspect.signature(controller)
    except (TypeError, ValueError):
        return False
    return _takes(signature) and not _takes(signature, 0.0, {})


def _takes(signature: inspect.Signature, *arguments: Any) -> bool:
    try:
        signature.bind(*arguments)
    except TypeError:
        return False
    return True


def _copied(value: Any, memo: dict[int, Any], where: str) -> Any:
    """Return a copy. `memo` is that of `copy.deepcopy`, so that what is shared within a controller stays shared."""
    if id(value) in memo:
        return memo[id(value)]
    if isinstance(value, types.FunctionType):
        return _copied_function(value, memo, where)
    if isinstance(value, types.MethodType):
        return types.MethodType(value.__func__, _copied(value.__self__, memo, where))
    if isinstance(value, functools.partial):
        arguments = [_copied(one, memo, where) for one in value.args]
        named = {name: _copied(one, memo, f"{name} of {where}") for name, one in value.keywords.items()}
        return functools.partial(_copied(value.func, memo, where), *arguments, **named)
    if isinstance(value, SHARED):
        return value
    # `copy.deepcopy` copies no functions: it gets none of the containers and objects that may hold some.
    made: Any
    if type(value) is dict:
        made = memo[id(value)] = {}
        made.update(
            (_copied(key, memo, where), _copied(one, memo, f"{key!r} of {where}")) for key, one in value.items()
        )
        return made
    if type(value) is list:
        made = memo[id(value)] = []
        made.extend(_copied(one, memo, where) for one in value)
        return made
    if type(value) is tuple:
        return tuple(_copied(one, memo, where) for one in value)
    if _is_plain(value):
        made = memo[id(value)] = object.__new__(type(value))
        made.__dict__.update({name: _copied(one, memo, f"{name} of {where}") for name, one in value.__dict__.items()})
        return made
    try:
        return copy.deepcopy(value, memo)
    except Exception as error:
        raise TypeError(
            f"{where} = {shortened(value)} cannot be copied for each run ({error}): give a function without parameters "
            "that makes the controller, or an object with __deepcopy__"
        ) from error


def _is_plain(value: Any) -> bool:
    """Tell whether all state of an object is in its ``__dict__``, and its class does not say how it is copied."""
    kind = type(value)
    standard = ("__new__", "__reduce__", "__reduce_ex__", "__getstate__")
    own = ("__deepcopy__", "__setstate__", "__getnewargs__", "__getnewargs_ex__", "__slots__")
    return (
        hasattr(value, "__dict__")
        and all(getattr(kind, name, None) is getattr(object, name, None) for name in standard)
        and not any(hasattr(kind, name) for name in own)
    )


def _copied_function(function: types.FunctionType, memo: dict[int, Any], where: str) -> types.FunctionType:
    """Return a function with variables, defaults and attributes of its own."""
    if function.__dict__.keys() - {"__wrapped__"} and function.__globals__.get(function.__name__) is function:
        raise TypeError(
            f"{where}: {function.__name__} keeps {', '.join(function.__dict__)} among its attributes, which all runs "
            "would share: keep them in an object, or in variables of an enclosing function"
        )
    cells = [_cell_of(cell, memo) for cell in function.__closure__ or ()]
    made = types.FunctionType(function.__code__, function.__globals__, function.__name__, None, tuple(cells) or None)
    memo[id(function)] = made
    memo.setdefault(id(memo), []).append(function)
    for name, old, new in zip(function.__code__.co_freevars, function.__closure__ or (), cells, strict=True):
        if _is_filled(old) and not _is_filled(new):
            new.cell_contents = _copied(old.cell_contents, memo, name)
    if function.__defaults__ is not None:
        made.__defaults__ = tuple(
            _copied(one, memo, f"a default of {function.__name__}") for one in function.__defaults__
        )
    if function.__kwdefaults__ is not None:
        made.__kwdefaults__ = {name: _copied(one, memo, name) for name, one in function.__kwdefaults__.items()}
    made.__dict__.update({name: _copied(one, memo, name) for name, one in function.__dict__.items()})
    made.__qualname__, made.__module__, made.__doc__ = function.__qualname__, function.__module__, function.__doc__
    return made


def _cell_of(cell: types.CellType, memo: dict[int, Any]) -> types.CellType:
    """Return the cell in place of one; functions that share a variable share its copy."""
    return memo.setdefault(id(cell), types.CellType())  # type: ignore[no-any-return]


def _is_filled(cell: types.CellType) -> bool:
    try:
        _ = cell.cell_contents
    except ValueError:
        return False
    return True


def described(controller: Any) -> str:
    """Return a text by which a resumed study recognises its controller: its code, and values that it begins with."""
    if isinstance(controller, tuple | str):
        return repr(controller)
    if isinstance(controller, functools.partial):
        return f"partial {described(controller.func)} {_plain([controller.args, sorted(controller.keywords.items())])}"
    if isinstance(controller, types.MethodType):
        return f"{controller.__func__.__qualname__} {described(controller.__self__)}"
    if isinstance(controller, types.FunctionType):
        kept = [cell.cell_contents for cell in controller.__closure__ or () if _is_filled(cell)]
        return f"{_code_of(controller)} {_plain(kept)} {_plain(controller.__defaults__)}"
    state = sorted(getattr(controller, "__dict__", {}).items())
    return f"{type(controller).__module__}.{type(controller).__qualname__} {_plain(state)}"


def _code_of(function: types.FunctionType) -> str:
    code = function.__code__
    numbers = [one for one in code.co_consts if not isinstance(one, types.CodeType)]
    return f"{function.__qualname__} {code.co_code.hex()} {numbers!r} {code.co_names!r}"


def _plain(value: Any) -> str:
    """Return a text of values; of those without a text of their own, which would hold an address, the type."""
    if isinstance(value, types.FunctionType):
        return _code_of(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_plain(one) for one in value)}]"
    text = repr(value)
    return type(value).__qualname__ if " at 0x" in text else text
