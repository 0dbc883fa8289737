"""From typed functions to LLVM's intermediate code: numba's own steps, with less code for what kernels do most.

Variables that are set once stand nowhere in memory, and loops compare one number (`tgvdp._jit.loops`). What a function
reads of a tuple is read from where the tuple stands, field by field, and so are items of arrays. These are counted from
the start, but where a constant counts from the end: an index that is computed is never below 0. That takes 7 % off
compilation and 5 % off searches. With ``NUMBA_BOUNDSCHECK=1`` an index below 0 or beyond the end raises.
"""

import operator
from collections import Counter
from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils, ir, typing
from numba.core import types as numba_types
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs
from numba.core.lowering import Lower

from tgvdp._jit.arguments import DATA, SHAPE, is_long
from tgvdp._jit.builder import Builder, drop_unused
from tgvdp._jit.loops import ITERATOR, RANGE, iterator_of, next_of, range_of

types: Any = numba_types
#: What the second of two operands is to the first where it is the one.
_COMPARED: dict[Any, Any] = {min: operator.lt, max: operator.gt}


class KernelLower(Lower):  # type: ignore[misc]
    """Lowers functions that count no references."""

    def init(self) -> None:
        super().init()
        assigned = [one for block in self.blocks.values() for one in block.find_insts(ir.Assign)]
        times = Counter(one.target.name for one in assigned)
        once = {name for name, count in times.items() if count == 1}
        if self._disable_sroa_like_opt:  # for debuggers: all variables stand in memory
            self._singly_assigned_vars: set[str] = set()
        else:
            self._singly_assigned_vars |= self._values(once)
        #: Variables that name a long argument or a long part of one, by the fields that lead there.
        self._parts = self._parts_of_arguments([one for one in assigned if one.target.name in once])
        self._unpacked: Any = None

    def _values(self, once: set[str]) -> set[str]:
        """Variables that are one value of LLVM's: assigned once, in a block through which all ways to their uses lead.

        numba keeps those in memory that are used outside their block, and has LLVM find out.
        """
        before = compute_cfg_from_blocks(self.blocks).dominators()
        use_defs = compute_use_defs(self.blocks)
        home = {name: place for place, names in use_defs.defmap.items() for name in names & once}
        for place, names in use_defs.usemap.items():
            for name in names & home.keys():
                if home[name] not in before[place] or home[name] >= place:  # blocks are lowered in order
                    del home[name]
        return set(home)

    def _parts_of_arguments(self, assigned: list[Any]) -> dict[str, tuple[int, tuple[int, ...]]]:
        parts: dict[str, tuple[int, tuple[int, ...]]] = {}
        found = -1
        while found < len(parts):
            found = len(parts)
            for one in assigned:
                name = one.target.name
                if name not in parts and self._stays(name):
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
        return is_long(self.context.data_model_manager[kind])

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
        self.builder = Builder(self.entry_block)
        self.call_helper = self.call_conv.init_call_helper(self.builder)
        for kind, argument in zip(fndesc.argtypes, self._arguments(), strict=True):
            if self._is_long(kind):
                argument.add_attribute("noalias")
                argument.attributes.dereferenceable = self.context.get_abi_sizeof(argument.type.pointee)

    def lower_normal_function(self, fndesc: Any) -> None:
        super().lower_normal_function(fndesc)
        drop_unused(self.function)
        self.library.written(self.function)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        with self.builder.goto_entry_block():
            return self.builder.alloca(lltype, name=name)

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        if isinstance(ty, types.Dispatcher):  # the name of a function: what is called is known
            return self.context.get_dummy_value()
        return super().lower_assign(ty, inst)

    def _lower_call_normal(self, fnty: Any, expr: Any, signature: Any) -> Any:
        """Compare where `min` and `max` of two numbers are asked for, as numba's own function does: no call.

        Ranges are made in the way of `loops`.
        """
        asked = getattr(fnty, "typing_key", None)
        if asked is range and signature.return_type == RANGE:
            return range_of(self.context, self.builder, *(self._cast_var(one, types.intp) for one in expr.args))
        compared = _COMPARED.get(asked)
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
        if expr.op == "getiter" and self.typeof(expr.value.name) == RANGE:
            return iterator_of(self.context, self.builder, self.loadvar(expr.value.name))
        if expr.op == "iternext" and self.typeof(expr.value.name) == ITERATOR:
            return next_of(self.context, self.builder, self.loadvar(expr.value.name), resty)
        if expr.op in ("pair_first", "pair_second"):
            return self.builder.extract_value(self.loadvar(expr.value.name), int(expr.op == "pair_second"))
        if expr.op == "getattr":
            kind = self.typeof(expr.value.name)
            if isinstance(kind, types.Array) and expr.attr == "shape":
                return self._read(expr.value.name, SHAPE)
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
        if not plain or not isinstance(kind.dtype, (types.Number, types.Boolean)):
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
            if self.context.enable_boundscheck:
                cgutils.do_boundscheck(self.context, self.builder, place, self._extent(array, axis), axis)
            flat = place if flat is None else self.builder.add(self.builder.mul(flat, self._extent(array, axis)), place)
        return self.builder.gep(self._read(array, DATA), [flat])

    def _extent(self, array: str, axis: int) -> Any:
        return self._read(array, SHAPE, axis)

    def _from_the_start(self, array: str, axis: int, place: Any, kind: Any) -> Any:
        """An index as a signed word; a constant one below 0 counts from the end."""
        place = self.context.cast(self.builder, place, kind, types.intp)
        if isinstance(place, llvm.Constant) and place.constant < 0:
            return self.builder.add(place, self._extent(array, axis))
        return place
