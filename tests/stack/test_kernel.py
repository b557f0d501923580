import numba
import pytest

from scaloft_fi.stack.kernel import jit, joined, with_globals


def test_a_kernel_computes_what_its_function_says():
    @jit
    def half(x):
        return x / 2.0

    assert half(3.0) == 1.5


def test_a_division_by_zero_gives_infinity_as_in_numpy():
    @jit
    def inverse(x):
        return 1.0 / x

    assert inverse(0.0) == float("inf")


def test_without_a_place_for_the_cache_a_kernel_still_compiles(monkeypatch):
    real = numba.njit

    def nowhere(*args, cache=False, **options):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return real(*args, **options)

    monkeypatch.setattr(numba, "njit", nowhere)

    @jit
    def double(x):
        return 2 * x

    assert double(4) == 8


def test_another_error_of_the_compiler_is_not_hidden(monkeypatch):
    def broken(*args, **options):
        raise TypeError("broken")

    monkeypatch.setattr(numba, "njit", broken)
    with pytest.raises(TypeError, match="broken"):
        jit(lambda x: x)


def test_machine_code_of_joined_kernels_has_a_name_that_changes_with_their_sources(tmp_path):
    def name_when_a_part_is(text):
        source = tmp_path / "part.py"
        source.write_text(text)
        space = {}
        exec(compile(text, str(source), "exec"), space)

        @joined(space["part"])
        def whole():
            pass

        return whole.__qualname__

    plain = name_when_a_part_is("def part(x):\n    return x\n")
    assert name_when_a_part_is("def part(x):\n    return x\n") == plain
    assert name_when_a_part_is("STEP = 2\ndef part(x):\n    return x\n") != plain


def test_the_name_of_joined_kernels_changes_with_what_their_parts_call(tmp_path):
    def part_called(name):
        def part():
            pass

        part.__qualname__ = name
        return part

    def name_with(part):
        @joined(part)
        def whole():
            pass

        return whole.__qualname__

    assert name_with(part_called("part_1")) == name_with(part_called("part_1"))
    assert name_with(part_called("part_1")) != name_with(part_called("part_2"))


def _applied(x):
    return kernel(x) + 1.0  # noqa: F821 - given by `with_globals`


def test_a_copy_with_other_globals_calls_other_kernels():
    def double(x):
        return 2.0 * x

    def half(x):
        return 0.5 * x

    one, other = (jit(with_globals(_applied, kernel=jit(kernel))) for kernel in (double, half))
    assert (one(4.0), other(4.0)) == (9.0, 3.0)
