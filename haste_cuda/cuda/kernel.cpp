#include "cuda/kernel.h"

#include <stdexcept>

#include "cuda/check.h"
#include "cuda/nvtx.h"
#include "host/stopwatch.h"

namespace haste::cuda {

namespace {

int attribute_of(CUfunction function, FunctionAttribute which, const std::string& name) {
    int value = 0;
    HASTE_CUDA_CHECK(driver().function_get_attribute(&value, which, function), name);
    return value;
}

}  // namespace

Kernel::Kernel(const CachedProgram& program, const char* entry, std::string name)
    : name_(std::move(name)), cached_(program.cached) {
    const Stopwatch watch;
    HASTE_CUDA_CHECK(driver().module_load_data(&module_, program.program.cubin.data()), name_);
    try {
        HASTE_CUDA_CHECK(driver().module_get_function(&function_, module_, entry), name_);
        attributes_ = {
            .registers = attribute_of(function_, FunctionAttribute::registers, name_),
            .local_bytes = attribute_of(function_, FunctionAttribute::local_bytes, name_),
            .max_threads_per_block =
                attribute_of(function_, FunctionAttribute::max_threads_per_block, name_)};
        if (driver().function_get_parameter != nullptr) {
            std::size_t offset = 0;
            HASTE_CUDA_CHECK(
                driver().function_get_parameter(function_, 0, &offset, &parameters_size_), name_);
        }
    } catch (const CudaError&) {
        report(driver().module_unload(module_), "cuModuleUnload");
        throw;
    }
    build_seconds_ = program.seconds + watch.seconds();
}

Kernel::~Kernel() {
    if (module_ != nullptr) {
        report(driver().module_unload(module_), "cuModuleUnload");
    }
}

Kernel::Kernel(Kernel&& other) noexcept
    : name_(std::move(other.name_)),
      module_(std::exchange(other.module_, nullptr)),
      function_(std::exchange(other.function_, nullptr)),
      attributes_(other.attributes_),
      parameters_size_(other.parameters_size_),
      build_seconds_(other.build_seconds_),
      cached_(other.cached_) {}

void Kernel::launch_untyped(const Launch& shape, Stream& stream, const void* parameters,
                            std::size_t size) const {
    if (shape.blocks == 0) {
        return;
    }
    const auto subject = [&] {
        return name_ + ", " + std::to_string(shape.blocks) + " blocks of " +
               std::to_string(shape.threads) + " threads";
    };
    if (shape.threads < 1 || shape.threads > attributes_.max_threads_per_block) {
        throw CudaError("the launch [" + subject() +
                        "] is refused: a block of this kernel has 1 to " +
                        std::to_string(attributes_.max_threads_per_block) + " threads");
    }
    constexpr std::size_t max_blocks = 0x7fffffff;
    if (shape.blocks > max_blocks) {
        throw CudaError("the launch [" + subject() + "] is refused: a grid has at most " +
                        std::to_string(max_blocks) + " blocks");
    }
    if (parameters_size_ != 0 && parameters_size_ != size) {
        throw std::logic_error("the launch [" + subject() + "] has parameters of " +
                               std::to_string(size) + " bytes, the kernel's have " +
                               std::to_string(parameters_size_));
    }
    const NvtxRange range(name_.c_str());
    void* arguments[] = {const_cast<void*>(parameters)};
    HASTE_CUDA_CHECK(driver().launch_kernel(function_, static_cast<unsigned>(shape.blocks), 1, 1,
                                            static_cast<unsigned>(shape.threads), 1, 1,
                                            static_cast<unsigned>(shape.dynamic_shared_bytes),
                                            stream.handle(), arguments, nullptr),
                     subject());
    stream.note_launch(name_);
}

int Kernel::resident_blocks(int threads, std::size_t dynamic_shared_bytes) const {
    int blocks = 0;
    HASTE_CUDA_CHECK(
        driver().occupancy_max_active_blocks(&blocks, function_, threads, dynamic_shared_bytes),
        name_);
    return blocks;
}

KernelSet::KernelSet(const Device& device)
    : architecture_(architecture_for(device.info().compute_capability_major,
                                     device.info().compute_capability_minor)),
      cache_(CubinCache::standard()) {}

template <class Specification>
const Kernel& KernelSet::get_or_build(const Specification& specification) {
    std::string name = specification.name();
    if (const auto found = kernels_.find(name); found != kernels_.end()) {
        return found->second;
    }
    const CachedProgram program =
        load_or_compile(kernel_translation(specification, architecture_), cache_);
    const Kernel& kernel =
        kernels_.emplace(name, Kernel(program, kernel_entry, name)).first->second;
    build_seconds_ += kernel.build_seconds();
    return kernel;
}

const Kernel& KernelSet::get(const KernelSpecification& specification) {
    return get_or_build(specification);
}

const Kernel& KernelSet::get(const ReplaySpecification& specification) {
    return get_or_build(specification);
}

}  // namespace haste::cuda
