import numba
import pytest

from scaloft_fi.stack.kernel import jit, joined, with_globals


def test_a_kernel_computes_what_its_function_says_and_divides_by_zero_as_numpy_does():
    inverse = jit(lambda x: 1.0 / x)
    assert (inverse(4.0), inverse(0.0)) == (0.25, float("inf"))


def test_without_a_place_for_the_cache_a_kernel_still_compiles(monkeypatch):
    real = numba.njit

    def nowhere(*args, cache=False, **options):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return real(*args, **options)

    monkeypatch.setattr(numba, "njit", nowhere)
    assert jit(lambda x: 2 * x)(4) == 8


def test_another_error_of_the_compiler_is_not_hidden(monkeypatch):
    def broken(*args, **options):
        raise TypeError("broken")

    monkeypatch.setattr(numba, "njit", broken)
    with pytest.raises(TypeError, match="broken"):
        jit(lambda x: x)


def test_machine_code_of_joined_kernels_has_a_name_that_changes_with_their_sources_and_what_they_call(tmp_path):
    def name_with(text, name="part"):
        source, space = tmp_path / "part.py", {}
        source.write_text(text)
        exec(compile(text, str(source), "exec"), space)
        space["part"].__qualname__ = name
        return joined(space["part"])(lambda: None).__qualname__

    text = "def part(x):\n    return x\n"
    assert name_with(text) == name_with(text)
    assert len({name_with(text), name_with(f"STEP = 2\n{text}"), name_with(text, "part_2")}) == 3


def _applied(x):
    return kernel(x) + 1.0  # noqa: F821 - given by `with_globals`


def test_a_copy_with_other_globals_calls_other_kernels():
    def double(x):
        return 2.0 * x

    def half(x):
        return 0.5 * x

    one, other = (jit(with_globals(_applied, kernel=jit(kernel))) for kernel in (double, half))
    assert (one(4.0), other(4.0)) == (9.0, 3.0)
