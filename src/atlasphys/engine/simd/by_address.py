"""Tables of arrays that compiled functions pass to each other by address.

Numba takes a NamedTuple of arrays apart wherever it is passed: nine arguments for each array of a vector, hundreds for a table. Most of the time that
the step's kernel would take to compile goes into that, and some of its run time. ``by_address`` gives a class of tables a type of its own: the kernel
that Python calls puts the arrays' descriptions into its frame once, and all that it calls get that address, and read what they use.
"""

from __future__ import annotations

from typing import Any, ClassVar, TypeVar

from llvmlite import ir
from numba.core import cgutils
from numba.core import imputils as _imputils
from numba.core import pythonapi as _pythonapi
from numba.core import types as _types
from numba.core.datamodel import models as _models
from numba.core.datamodel import registry as _registry
from numba.core.registry import cpu_target
from numba.core.typing import templates as _templates
from numba.core.typing.typeof import typeof_impl
from numba.np import arrayobj as _arrayobj

from atlasphys.engine.simd.atomic import compiled_as

# Numba's and llvmlite's own annotations are incomplete: hence Any, and bases and decorators that mypy is told to let pass.
types: Any = _types
models: Any = _models
registry: Any = _registry
imputils: Any = _imputils
pythonapi: Any = _pythonapi
templates: Any = _templates
arrayobj: Any = _arrayobj

Class = TypeVar("Class", bound=type)

_I64 = ir.IntType(64)
_BYTE = ir.IntType(8)


class Address(type(_BYTE.as_pointer())):  # type: ignore[misc]
    """LLVM's type of the address of a table: where its fields lie, and the size of all, in bytes."""

    def __init__(self, field_types: dict[str, Any]) -> None:
        super().__init__(_BYTE)
        self.field_types, self.offsets, self.size = field_types, {}, 0
        for name, field in field_types.items():
            self.offsets[name] = self.size
            self.size += -(-cpu_target.target_context.get_abi_sizeof(field) // 8) * 8

    def field(self, builder: Any, address: Any, name: str) -> Any:
        """Pointer to a field."""
        pointer = builder.gep(address, [ir.Constant(_I64, self.offsets[name])])
        return builder.bitcast(pointer, self.field_types[name].as_pointer())


class _ArgumentAttributes(ir.values.ArgumentAttributes):  # type: ignore[misc]
    """llvmlite's list of attributes lacks one, and another has changed its name in LLVM, which reads both."""

    _known: ClassVar[dict[str, bool]] = {**ir.values.ArgumentAttributes._known, "nocapture": False, "readonly": False}


class TableType(types.Type):  # type: ignore[misc]
    """Numba's type of a table with certain arrays."""

    def __init__(self, table: type, kinds: tuple[Any, ...]) -> None:
        self.table, self.kinds = table, kinds
        self.fields: dict[str, Any] = dict(zip(table._fields, kinds, strict=True))  # type: ignore[attr-defined]
        super().__init__(f"{table.__module__}.{table.__qualname__}({', '.join(map(str, kinds))})")


def by_address(table: Class) -> Class:
    """Have compiled code pass tables of a NamedTuple's class by address. Compiled code can read their fields by name, but make none, save by
    ``part_of``."""

    @typeof_impl.register(table)
    def _type_of(value: Any, context: Any) -> Any:
        return TableType(table, tuple(typeof_impl(field, context) for field in value))

    return table


def part_of(tables: Any, index: int) -> Any:
    """Of a table of arrays the table of their parts ``array[index]``. Compiled, it holds until the function that asks for it returns."""
    return type(tables)(*(field[index] for field in tables))


@compiled_as(part_of)
def _part_of(typing: Any, tables: Any, index: Any) -> Any:
    kinds = tuple(kind.copy(ndim=kind.ndim - 1) for kind in tables.kinds)
    part = TableType(tables.table, kinds)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        form = context.get_value_type(part)
        with builder.goto_entry_block():
            room = builder.bitcast(builder.alloca(ir.ArrayType(_I64, form.size // 8)), form)
        for (name, whole), kind in zip(tables.fields.items(), kinds, strict=True):
            array = context.make_array(whole)(context, builder, read_field(context, builder, tables, values[0], name))
            shape, strides = (
                cgutils.unpack_tuple(builder, numbers, whole.ndim) for numbers in (array.shape, array.strides)
            )
            entry = context.make_array(kind)(context, builder)
            arrayobj.populate_array(
                entry,
                data=cgutils.pointer_add(builder, array.data, builder.mul(values[1], strides[0]), array.data.type),
                shape=shape[1:],
                strides=strides[1:],
                itemsize=array.itemsize,
                meminfo=None,
            )
            builder.store(entry._getvalue(), form.field(builder, room, name))
        return room

    return part(tables, types.int64), generate


def unchanging(function: Any) -> None:
    """Tell LLVM that nothing changes the tables whose addresses a function is given, so that it need not read them again."""
    for argument in function.args:
        if isinstance(argument.type, Address):
            argument.attributes = _ArgumentAttributes(("noalias", "nocapture", "readonly"))
            argument.attributes.dereferenceable = argument.type.size


@registry.register_default(TableType)
class _TableModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: TableType) -> None:
        super().__init__(
            manager, kind, Address({name: manager[field].get_value_type() for name, field in kind.fields.items()})
        )


@templates.infer_getattr
class _Fields(templates.AttributeTemplate):  # type: ignore[misc]
    key = TableType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """The type of a field."""
        return kind.fields.get(name)


def read_field(context: Any, builder: Any, kind: TableType, address: Any, name: str) -> Any:
    """LLVM value of a table's field."""
    return builder.load(context.get_value_type(kind).field(builder, address, name))


@imputils.lower_getattr_generic(TableType)  # type: ignore[untyped-decorator]
def _get_field(context: Any, builder: Any, kind: TableType, address: Any, name: str) -> Any:
    return imputils.impl_ret_borrowed(
        context, builder, kind.fields[name], read_field(context, builder, kind, address, name)
    )


@pythonapi.unbox(TableType)  # type: ignore[untyped-decorator]
def _take_over(kind: TableType, table: Any, c: Any) -> Any:
    form = c.context.get_value_type(kind)
    with c.builder.goto_entry_block():
        room = c.builder.bitcast(c.builder.alloca(ir.ArrayType(_I64, form.size // 8)), form)
    failed = ir.Constant(ir.IntType(1), 0)
    taken = []
    for i, (name, field) in enumerate(kind.fields.items()):
        native = c.unbox(field, c.pyapi.tuple_getitem(table, i))
        c.builder.store(native.value, form.field(c.builder, room, name))
        failed = c.builder.or_(failed, native.is_error)
        taken.append((field, native))

    def give_back() -> None:
        for field, native in reversed(taken):
            if native.cleanup is not None:
                native.cleanup()
            if c.context.enable_nrt:
                c.context.nrt.decref(c.builder, field, native.value)

    return pythonapi.NativeValue(room, cleanup=give_back, is_error=failed)
