"""NVRTC: what it reports, what it refuses, and how the report is read."""

from types import ModuleType

import pytest
from faults import faults

ARCHITECTURES = (75, 80, 90, 100)

COPY = """
extern "C" __global__ void copy(const float* from, float* to) {
    to[threadIdx.x] = from[threadIdx.x];
}
"""

# A local array that is indexed at run time needs a stack; 0.5 KiB of shared memory is declared.
STACK = """
extern "C" __global__ void shuffle(const int* from, int* to) {
    __shared__ int shared[128];
    int local[32];
    for (int i = 0; i < 32; ++i) local[from[i] & 31] = i;
    shared[threadIdx.x] = local[from[32] & 31];
    __syncthreads();
    to[threadIdx.x] = shared[127 - threadIdx.x];
}
extern "C" __global__ void empty() {}
"""

# Far more values are alive at once than a thread that may use 24 registers can hold.
SPILLS = """
extern "C" __global__ void crowd(const float* from, float* to) {
    float values[64];
    #pragma unroll
    for (int i = 0; i < 64; ++i) values[i] = from[i * 1024 + threadIdx.x];
    __syncthreads();
    #pragma unroll
    for (int i = 0; i < 64; ++i) to[i * 1024 + threadIdx.x] = values[63 - i] * values[i];
}
"""


@pytest.mark.parametrize("architecture", ARCHITECTURES)
def test_a_kernel_compiles_for_every_architecture(compiler: ModuleType, architecture: int):
    result = compiler.compile_source(COPY, architecture, use_cache=False)
    assert result["cubin"].startswith(b"\x7fELF")
    assert result["kernels"]["copy"]["registers"] > 0, result["log"]
    assert f"'sm_{architecture}'" in result["log"]


@pytest.mark.usefixtures("cache")
def test_resources_are_read_for_each_kernel(compiler: ModuleType):
    kernels = compiler.compile_source(STACK, 80, use_cache=False)["kernels"]
    assert set(kernels) == {"shuffle", "empty"}
    assert kernels["shuffle"]["stack_bytes"] >= 4 * 32
    assert kernels["shuffle"]["shared_bytes"] == 4 * 128
    assert kernels["empty"]["stack_bytes"] == 0
    assert kernels["empty"]["shared_bytes"] == 0


def test_spills_are_seen(compiler: ModuleType):
    """Negative control of every claim of zero spills."""
    options = ["--maxrregcount=24"]
    result = compiler.compile_source(SPILLS, 90, options, use_cache=False)
    crowd = result["kernels"]["crowd"]
    assert crowd["spill_store_bytes"] > 0, result["log"]
    assert crowd["spill_load_bytes"] > 0, result["log"]
    assert len(faults(result, kernel="crowd")) == 2, faults(result, kernel="crowd")


def test_registers_and_warnings_are_faults(compiler: ModuleType):
    """Negative control of the same claims: an unused variable, and more blocks than fit."""
    unused = COPY.replace(") {", ") { int unused;")
    result = compiler.compile_source(unused, 90, use_cache=False)
    assert any("unused" in line for line in faults(result, kernel="copy")), result["log"]
    plain = compiler.compile_source(COPY, 90, use_cache=False)
    assert not faults(plain, kernel="copy", blocks=1), plain["log"]
    assert faults(plain, kernel="copy", blocks=1000), plain["kernels"]


def test_a_syntax_error_shows_the_compilers_log(compiler: ModuleType):
    with pytest.raises(compiler.CompileError) as raised:
        compiler.compile_source("__global__ void f() { int x = ; }", 90, [], "broken.cu")
    message = str(raised.value)
    assert "broken.cu(1): error" in message, message
    assert "--gpu-architecture=sm_90" in message, message


def test_an_unknown_option_is_named(compiler: ModuleType):
    with pytest.raises(compiler.CompileError, match="--no-such-option"):
        compiler.compile_source(COPY, 90, ["--no-such-option"], use_cache=False)


def test_an_architecture_that_no_compiler_knows_is_named(compiler: ModuleType):
    with pytest.raises(compiler.CompileError, match="sm_12"):
        compiler.compile_source(COPY, 12, use_cache=False)


def test_all_architectures_of_the_kernels_are_supported(compiler: ModuleType):
    assert set(ARCHITECTURES) <= set(compiler.nvrtc_architectures())


def test_multiply_and_add_stay_apart_when_asked(compiler: ModuleType):
    """The option on which equal bits on both sides rest reaches the compiler."""
    source = 'extern "C" __global__ void k(float* p) { p[0] = p[1] * p[2] + p[3]; }'
    apart = compiler.compile_source(source, 90, ["--fmad=false"], use_cache=False)
    fused = compiler.compile_source(source, 90, ["--fmad=true"], use_cache=False)
    assert apart["cubin"] != fused["cubin"]
