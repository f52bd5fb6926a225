// An NVRTC that has g++ compile kernels for the processor. A "cubin" is the path of a library.
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

struct nvrtcProgram_st {
    std::string source, cubin, log;
};
using nvrtcProgram = nvrtcProgram_st*;

extern "C" {

const char* nvrtcGetErrorString(int) { return "g++ failed"; }

int nvrtcVersion(int* major, int* minor) {
    *major = 13;
    *minor = 0;
    return 0;
}

int nvrtcGetNumSupportedArchs(int* count) {
    *count = 1;
    return 0;
}

int nvrtcGetSupportedArchs(int* architectures) {
    architectures[0] = 90;
    return 0;
}

int nvrtcCreateProgram(nvrtcProgram* program, const char* source, const char*, int,
                       const char* const*, const char* const*) {
    *program = new nvrtcProgram_st{source, "", ""};
    return 0;
}

int nvrtcDestroyProgram(nvrtcProgram* program) {
    delete *program;
    *program = nullptr;
    return 0;
}

int nvrtcCompileProgram(nvrtcProgram program, int count, const char* const* options) {
    static int number = 0;
    const std::string folder = std::getenv("EMULATION_FOLDER");
    const std::string stem = folder + "/kernel" + std::to_string(number++);
    std::ofstream(stem + ".cpp")
        << program->source
        << "extern \"C\" void emulated_launch(const void* parameters, unsigned blocks, unsigned "
           "threads) {\n    run_threads(haste_kernel, parameters, blocks, threads);\n}\n";
    std::string command = "g++ -std=c++20 -O1 -w -shared -fPIC -ffp-contract=off -fno-math-errno";
    for (int i = 0; i < count; ++i) {
        const std::string option = options[i];
        const std::string include = "--include-path=";
        if (option.starts_with(include)) command += " -I'" + option.substr(include.size()) + "'";
    }
    command += " -include '" + std::string(std::getenv("EMULATION_HEADER")) + "' -o " + stem +
               ".so " + stem + ".cpp 2> " + stem + ".log";
    const int failed = std::system(command.c_str());
    std::stringstream log;
    log << std::ifstream(stem + ".log").rdbuf();
    program->log = log.str();
    program->cubin = stem + ".so";
    return failed ? 6 : 0;
}

int nvrtcGetProgramLogSize(nvrtcProgram program, std::size_t* size) {
    *size = program->log.size() + 1;
    return 0;
}

int nvrtcGetProgramLog(nvrtcProgram program, char* log) {
    std::strcpy(log, program->log.c_str());
    return 0;
}

int nvrtcGetCUBINSize(nvrtcProgram program, std::size_t* size) {
    *size = program->cubin.size() + 1;
    return 0;
}

int nvrtcGetCUBIN(nvrtcProgram program, char* cubin) {
    std::strcpy(cubin, program->cubin.c_str());
    return 0;
}

}  // extern "C"
