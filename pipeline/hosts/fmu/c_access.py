"""Memory and functions of C, reached by their addresses from code that njit compiles."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

_REAL = {32: ir.FloatType(), 64: ir.DoubleType()}


def _loading(bits, kind):
    """An intrinsic: element i of the array at an address as float64. kind: "real", "signed" or "plain" (unsigned)."""

    @intrinsic
    def load(typingctx, address, i):
        def generate(context, builder, signature, args):
            machine = _REAL[bits] if kind == "real" else ir.IntType(bits)
            array = builder.inttoptr(args[0], machine.as_pointer())
            value = builder.load(builder.gep(array, [args[1]]))
            if kind == "real":
                return value if bits == 64 else builder.fpext(value, _REAL[64])
            return (builder.sitofp if kind == "signed" else builder.uitofp)(value, _REAL[64])

        return types.float64(types.int64, types.int64), generate

    return load


def _storing(bits, kind):
    """An intrinsic: puts a float64, which the type must hold, at element i of the array at an address."""

    @intrinsic
    def store(typingctx, address, i, value):
        def generate(context, builder, signature, args):
            machine = _REAL[bits] if kind == "real" else ir.IntType(bits)
            array = builder.inttoptr(args[0], machine.as_pointer())
            value = args[2]
            if kind == "real":
                value = value if bits == 64 else builder.fptrunc(value, machine)
            else:
                value = (builder.fptosi if kind == "signed" else builder.fptoui)(value, machine)
            builder.store(value, builder.gep(array, [args[1]]))
            return context.get_dummy_value()

        return types.void(types.int64, types.int64, types.float64), generate

    return store


load_double, store_double = _loading(64, "real"), _storing(64, "real")
load_float, store_float = _loading(32, "real"), _storing(32, "real")
load_int8, store_int8 = _loading(8, "signed"), _storing(8, "signed")
load_uint8, store_uint8 = _loading(8, "plain"), _storing(8, "plain")
load_int16, store_int16 = _loading(16, "signed"), _storing(16, "signed")
load_uint16, store_uint16 = _loading(16, "plain"), _storing(16, "plain")
load_int32, store_int32 = _loading(32, "signed"), _storing(32, "signed")
load_uint32, store_uint32 = _loading(32, "plain"), _storing(32, "plain")
store_int64, store_uint64 = _storing(64, "signed"), _storing(64, "plain")


@intrinsic
def word(typingctx, address, i):
    """Element i of the array of int64 at an address."""

    def generate(context, builder, signature, args):
        array = builder.inttoptr(args[0], ir.IntType(64).as_pointer())
        return builder.load(builder.gep(array, [args[1]]))

    return types.int64(types.int64, types.int64), generate


@intrinsic
def as_words(typingctx, vector):
    """The same address as that of int64."""

    def generate(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64).as_pointer())

    return types.CPointer(types.int64)(types.CPointer(types.float64)), generate


@intrinsic
def address_of_element(typingctx, vector, i):
    """The machine address of an element of an array of float64."""
    signature = types.int64(vector, types.int64)

    def generate(context, builder, signature, args):
        array = context.make_array(signature.args[0])(context, builder, args[0])
        return builder.ptrtoint(builder.gep(array.data, [args[1]]), ir.IntType(64))

    return signature, generate


def _call(returns, *takes):
    """Signature and code of a call of the C function at an address; i: int32, w: int64 or address, d: double."""
    letters = {
        "i": (types.int32, ir.IntType(32)),
        "w": (types.int64, ir.IntType(64)),
        "d": (types.float64, ir.DoubleType()),
    }
    numba_types, machine_types = zip(*(letters[one] for one in takes), strict=True)

    def generate(context, builder, signature, args):
        function = ir.FunctionType(letters[returns][1], machine_types)
        found = builder.call(builder.inttoptr(args[0], function.as_pointer()), args[1:])
        return builder.sext(found, ir.IntType(64)) if returns == "i" else found

    return types.int64(types.int64, *numba_types), generate


@intrinsic
def exchange(typingctx, address, instance, references, n, values):
    """Set or Get of FMI 1 and 2."""
    return _call("i", *"wwww")


@intrinsic
def exchange_3(typingctx, address, instance, references, n, values, n_values):
    """Set or Get of FMI 3."""
    return _call("i", *"wwwww")


@intrinsic
def do_step(typingctx, address, instance, t, h, is_new):
    """Advance by doStep of FMI 1 and 2."""
    return _call("i", *"wddi")


@intrinsic
def do_step_3(typingctx, address, instance, t, h, is_new, event, terminate, early, last):
    """Advance by doStep of FMI 3."""
    return _call("i", *"wddiwwww")


@intrinsic
def ask(typingctx, address, t_ns, dt_ns, what):
    """Call the host's own function."""
    return _call("w", *"www")
