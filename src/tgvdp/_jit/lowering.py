"""From typed functions to LLVM's intermediate code: numba's own steps, with less code for what kernels do most.

numba hands tuples on word by word, seven words for each array in them, and puts every tuple together again in each
function that gets it: half of the code of large kernels was that. Here what is long is handed on as an address. What a
function reads of a tuple is read from there, field by field, and so are items of arrays.
"""

import functools
import operator
from collections import ChainMap, Counter
from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils, ir, typing
from numba.core import types as numba_types
from numba.core.datamodel import ArgPacker, DataModelManager, default_manager, models
from numba.core.errors import LoweringError
from numba.core.lowering import Lower

types: Any = numba_types
#: Longer tuples are handed on as an address. A train (42 words) is not: read from memory in each arc, it makes fronts
#: up to a tenth slower.
_FEW_WORDS = 48
#: What the second of two operands is to the first where it is the one.
_COMPARED: dict[Any, Any] = {min: operator.lt, max: operator.gt}
_DATA, _SHAPE = (default_manager[types.float64[::1]].get_field_position(name) for name in ("data", "shape"))


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


class _TupleModel(_ByAddress, models.TupleModel):  # type: ignore[misc]
    pass


class _UniTupleModel(_ByAddress, models.UniTupleModel):  # type: ignore[misc]
    pass


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


@functools.cache
def _changes(manager: Any) -> dict[str, Any]:
    """What is different in a context of numba's in which long tuples are handed on as addresses."""
    models_ = _Models(ChainMap({types.NamedTuple: _TupleModel, types.NamedUniTuple: _UniTupleModel}, manager._handlers))
    packer = functools.cache(functools.partial(ArgPacker, models_))
    return {
        "data_model_manager": models_,
        "get_arg_packer": lambda kinds: packer(tuple(kinds)),  # asked for several times in each call
        "cached_internal_func": {},
    }


def by_address(context: Any) -> Any:
    """Return a context of numba's in which long tuples are handed on as addresses."""
    manager = context.data_model_manager
    return context if isinstance(manager, _Models) else context.subtarget(**_changes(manager))


def call_of(fndesc: Any, libraries: list[Any]) -> Any:
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
        with cgutils.if_unlikely(builder, builder.icmp_signed("!=", code, code.type(0))):
            builder.ret(code)
        return context.get_returned_value(builder, fndesc.restype, builder.load(result))

    call.signature = fndesc.argtypes  # type: ignore[attr-defined]
    call.libs = tuple(libraries)  # type: ignore[attr-defined]
    return call


class KernelLower(Lower):  # type: ignore[misc]
    """Lowers functions that count no references."""

    def init(self) -> None:
        super().init()
        if self._disable_sroa_like_opt:  # for debuggers: all variables stand in memory
            self._singly_assigned_vars: set[str] = set()
        #: Variables that name a long argument or a long part of one, by the fields that lead there.
        self._parts = self._parts_of_arguments()
        self._unpacked: Any = None

    def _parts_of_arguments(self) -> dict[str, tuple[int, tuple[int, ...]]]:
        assigned = [one for block in self.blocks.values() for one in block.find_insts(ir.Assign)]
        times = Counter(one.target.name for one in assigned)
        parts: dict[str, tuple[int, tuple[int, ...]]] = {}
        found = -1
        while found < len(parts):
            found = len(parts)
            for one in assigned:
                name = one.target.name
                if times[name] == 1 and name not in parts and self._stays(name):
                    part = self._part(one.value, parts)
                    if part is not None:
                        parts[name] = part
        return parts

    def _stays(self, name: str) -> bool:
        """Whether a variable is to be read where it stands: long tuples, and arrays that are read once."""
        kind = self.typeof(name)
        return self._is_long(kind) or (isinstance(kind, types.Array) and name.startswith("$"))

    def _part(self, value: Any, parts: dict[str, Any]) -> tuple[int, tuple[int, ...]] | None:
        if isinstance(value, ir.Arg):
            return (value.index, ()) if self._is_long(self.fndesc.argtypes[value.index]) else None
        if isinstance(value, ir.Var):
            return parts.get(value.name)
        if isinstance(value, ir.Expr) and value.op == "getattr" and value.value.name in parts:
            index, path = parts[value.value.name]
            return index, (*path, self.typeof(value.value.name).fields.index(value.attr))
        return None

    def _is_long(self, kind: Any) -> bool:
        model = self.context.data_model_manager[kind]
        return isinstance(model, _ByAddress) and model.is_long()

    def _address(self, name: str, *path: int) -> Any:
        """Where a variable, or a field of it, stands in memory; None where it is a value of LLVM's."""
        if name in self._parts:
            index, before = self._parts[name]
            address, path = self._arguments()[index], (*before, *path)
        elif name in self._singly_assigned_vars or name in self._blk_local_varmap:
            return None
        else:
            address = self.getvar(name)
        word = llvm.IntType(32)
        return self.builder.gep(address, [word(0), *map(word, path)], inbounds=True) if path else address

    def _arguments(self) -> Any:
        if self._unpacked is None:
            packer = self.context.get_arg_packer(self.fndesc.argtypes)
            self._unpacked = packer._unflattener.unflatten(self.call_conv.get_arguments(self.function))
        return self._unpacked

    def _read(self, name: str, *path: int) -> Any:
        address = self._address(name, *path)
        return self.builder.extract_value(self.loadvar(name), path) if address is None else self.builder.load(address)

    def lower_inst(self, inst: Any) -> None:
        if isinstance(inst, ir.Assign) and inst.target.name in self._parts:
            return
        super().lower_inst(inst)

    def _alloca_var(self, name: str, fetype: Any) -> None:
        if name not in self._parts:
            super()._alloca_var(name, fetype)

    def loadvar(self, name: str) -> Any:
        return self.builder.load(self._address(name)) if name in self._parts else super().loadvar(name)

    def setup_function(self, fndesc: Any) -> None:
        """Say that nobody writes where arguments stand: else LLVM reads them again after each item that is stored."""
        super().setup_function(fndesc)
        for kind, argument in zip(fndesc.argtypes, self._arguments(), strict=True):
            if self._is_long(kind):
                argument.add_attribute("noalias")
                argument.attributes.dereferenceable = self.context.get_abi_sizeof(argument.type.pointee)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        with self.builder.goto_entry_block():
            return self.builder.alloca(lltype, name=name)

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        if isinstance(ty, types.Dispatcher):  # the name of a function: what is called is known
            return self.context.get_dummy_value()
        return super().lower_assign(ty, inst)

    def _lower_call_normal(self, fnty: Any, expr: Any, signature: Any) -> Any:
        """Compare where `min` and `max` of two numbers are asked for, as numba's own function does: no call."""
        compared = _COMPARED.get(getattr(fnty, "typing_key", None))
        if compared is None or len(expr.args) != 2 or expr.vararg or expr.kws:
            return super()._lower_call_normal(fnty, expr, signature)
        kind = signature.return_type
        first, second = (self._cast_var(one, kind) for one in expr.args)
        compare = self.context.get_function(compared, typing.signature(types.boolean, kind, kind))
        return self.builder.select(compare(self.builder, (second, first)), second, first)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        if name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self._alloca_var(name, self.typeof(name))
            self.builder.store(value, self.getvar(name))

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        if expr.op == "getattr":
            kind = self.typeof(expr.value.name)
            if isinstance(kind, types.BaseNamedTuple) and expr.attr in kind.fields:
                index = kind.fields.index(expr.attr)
                return self.context.cast(self.builder, self._read(expr.value.name, index), kind[index], resty)
        return super().lower_expr(resty, expr)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        item = self._item(value.name, index.name)
        if item is None:
            return super().lower_getitem(resty, expr, value, index, signature)
        kind = self.typeof(value.name).dtype
        return self.context.cast(self.builder, self.context.unpack_value(self.builder, kind, item), kind, resty)

    def lower_setitem(self, target_var: Any, index_var: Any, value_var: Any, signature: Any) -> Any:
        item = self._item(target_var.name, index_var.name)
        if item is None:
            return super().lower_setitem(target_var, index_var, value_var, signature)
        kind = self.typeof(target_var.name).dtype
        value = self.context.cast(self.builder, self.loadvar(value_var.name), self.typeof(value_var.name), kind)
        self.context.pack_value(self.builder, kind, value, item)
        return None

    def _item(self, array: str, index: str) -> Any:
        """Address of a number in an array; None where it is no number, or the array not of the plainest kind."""
        kind, index_kind = self.typeof(array), self.typeof(index)
        plain = isinstance(kind, types.Array) and kind.layout == "C" and kind.aligned
        if not plain or not isinstance(kind.dtype, (types.Number, types.Boolean)) or self.context.enable_boundscheck:
            return None
        places = self.loadvar(index)
        if isinstance(index_kind, types.BaseTuple):
            kinds = tuple(index_kind)
            values = [self.builder.extract_value(places, i) for i in range(len(kinds))]
        else:
            kinds, values = (index_kind,), [places]
        if len(kinds) != kind.ndim or not all(isinstance(one, types.Integer) for one in kinds):
            return None
        flat = None
        for axis, (one, place) in enumerate(zip(kinds, values, strict=True)):
            place = self._from_the_start(array, axis, place, one)
            flat = place if flat is None else self.builder.add(self.builder.mul(flat, self._extent(array, axis)), place)
        return self.builder.gep(self._read(array, _DATA), [flat])

    def _extent(self, array: str, axis: int) -> Any:
        return self._read(array, _SHAPE, axis)

    def _from_the_start(self, array: str, axis: int, place: Any, kind: Any) -> Any:
        """An index, counted from the end where it is below 0."""
        place = self.context.cast(self.builder, place, kind, types.intp if kind.signed else types.uintp)
        if not kind.signed:
            return place
        if isinstance(place, llvm.Constant) and place.constant >= 0:
            return place
        end = self.builder.add(place, self._extent(array, axis))
        if isinstance(place, llvm.Constant):
            return end
        return self.builder.select(self.builder.icmp_signed("<", place, place.type(0)), end, place)
