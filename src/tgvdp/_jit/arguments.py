"""How arguments go from function to function: numba's own way, with fewer words.

numba hands tuples on word by word, seven words and more for each array in them, and puts every tuple together again in
each function that gets it: half of the code of large kernels was that. Here what is long is handed on as an address,
and arrays in tuples as three or four words.
"""

import functools
import itertools
from collections import ChainMap
from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.datamodel import ArgPacker, DataModelManager, default_manager, models
from numba.core.errors import LoweringError
from numba.np.numpy_support import as_dtype

types: Any = numba_types
#: Longer tuples are handed on as an address. A train is not: read from memory in each arc, it makes fronts up to a
#: tenth slower.
_FEW_WORDS = 48
#: Places of an array's fields.
_PARENT, DATA, SHAPE = map(default_manager[types.float64[::1]].get_field_position, ("parent", "data", "shape"))


def _words(kind: llvm.Type) -> int:
    elements = getattr(kind, "elements", None)
    if isinstance(kind, llvm.ArrayType):
        return int(kind.count) * _words(kind.element)
    return 1 if elements is None else sum(map(_words, elements))


class _ByAddress(models.DataModel):  # type: ignore[misc]
    """Mixed into a model of tuples: an argument that is long is an address of it, which nobody writes to."""

    _long: bool | None = None

    def is_long(self) -> bool:
        long = self._long
        if long is None:
            long = self._long = _words(self.get_value_type()) > _FEW_WORDS
        return long

    def get_argument_type(self) -> Any:
        return self.get_value_type().as_pointer() if self.is_long() else super().get_argument_type()

    def as_argument(self, builder: Any, value: Any) -> Any:
        if not self.is_long():
            return super().as_argument(builder, value)
        address = _still_there(builder, value)
        if address is None:
            with builder.goto_entry_block():
                address = builder.alloca(value.type)
            builder.store(value, address)
        return address

    def from_argument(self, builder: Any, value: Any) -> Any:
        return builder.load(value) if self.is_long() else super().from_argument(builder, value)


class _ArrayModel(models.ArrayModel):  # type: ignore[misc]
    """An array without gaps, in a tuple: handed on as what Python knows it by, where its items are, and how many.

    All else follows from these.
    """

    def get_argument_type(self) -> Any:
        return self._handed_on(super().get_argument_type())

    def as_argument(self, builder: Any, value: Any) -> Any:
        return self._handed_on(super().as_argument(builder, value))

    def _handed_on(self, words: Any) -> Any:
        return words[_PARENT], words[DATA], words[SHAPE]

    def from_argument(self, builder: Any, value: Any) -> Any:
        parent, data, shape = value
        kinds = dict(zip(self._fields, self.get_value_type().elements, strict=True))
        item_bytes = llvm.Constant(kinds["itemsize"], as_dtype(self._fe_type.dtype).itemsize)
        *strides, _ = itertools.accumulate(reversed(shape), builder.mul, initial=item_bytes)
        words = {
            "meminfo": llvm.Constant(kinds["meminfo"], None),
            "parent": parent,
            "nitems": functools.reduce(builder.mul, shape),
            "itemsize": item_bytes,
            "data": data,
            "shape": shape,
            "strides": tuple(reversed(strides)),
        }
        return super().from_argument(builder, tuple(words[name] for name in self._fields))


def _in_tuple(model: Any) -> Any:
    """The model of what stands in a tuple: arrays by themselves go to functions of numba's, too, in its own way."""
    kind = model._fe_type
    return _ArrayModel(model._dmm, kind) if isinstance(kind, types.Array) and kind.layout == "C" else model


class _TupleModel(_ByAddress, models.TupleModel):  # type: ignore[misc]
    _models: Any

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._models = tuple(map(_in_tuple, self._models))


class _UniTupleModel(_ByAddress, models.UniTupleModel):  # type: ignore[misc]
    _elem_model: Any

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._elem_model = _in_tuple(self._elem_model)


def _still_there(builder: Any, value: Any) -> Any:
    """Where a value has just been read, if nothing was written there since."""
    if not isinstance(value, llvm.LoadInstr) or value.parent is not builder.block:
        return None
    (address,) = value.operands
    for later in reversed(builder.block.instructions):
        if later is value:
            return address
        if isinstance(later, llvm.StoreInstr) and later.operands[1] is address:
            return None
    return None


class _Models(DataModelManager):  # type: ignore[misc]
    """numba's models of types, but of tuples."""


def is_long(model: Any) -> bool:
    """Whether arguments of this model are handed on as an address."""
    return isinstance(model, _ByAddress) and model.is_long()


@functools.cache
def _changes(manager: Any) -> dict[str, Any]:
    """What is different in a context of numba's in which arguments are handed on so."""
    models_ = _Models(
        ChainMap(
            {types.NamedTuple: _TupleModel, types.NamedUniTuple: _UniTupleModel},
            manager._handlers,
        )
    )
    packer = functools.cache(functools.partial(ArgPacker, models_))
    return {
        "data_model_manager": models_,
        "get_arg_packer": lambda kinds: packer(tuple(kinds)),  # asked for several times in each call
        "cached_internal_func": {},
    }


def by_address(context: Any) -> Any:
    """Return a context of numba's in which arguments are handed on so."""
    manager = context.data_model_manager
    return context if isinstance(manager, _Models) else context.subtarget(**_changes(manager))


def call_of(fndesc: Any, libraries: list[Any], *, raises: bool) -> Any:
    """Return what writes the code that calls a linked function: numba's own, told an error by one number but 0."""
    if isinstance(fndesc.restype, types.Optional):
        raise LoweringError(f"{fndesc.qualname} returns None or a value: kernels call no such function")

    def call(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        context = by_address(context)
        function = context.declare_function(builder.module, fndesc)
        with builder.goto_entry_block():
            result = builder.alloca(context.call_conv.get_return_type(fndesc.restype).pointee)
        handed = context.get_arg_packer(fndesc.argtypes).as_arguments(builder, args)
        error = context.call_conv._get_excinfo_argument(builder.function)
        code = builder.call(function, [result, error, *handed])
        if raises:
            with cgutils.if_unlikely(builder, builder.icmp_signed("!=", code, code.type(0))):
                builder.ret(code)
        return context.get_returned_value(builder, fndesc.restype, builder.load(result))

    call.signature = fndesc.argtypes  # type: ignore[attr-defined]
    call.libs = tuple(libraries)  # type: ignore[attr-defined]
    return call
