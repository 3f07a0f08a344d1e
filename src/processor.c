// Before anything else of a program runs: OpenBLAS is told to start no threads, which would wait busily, and those of OpenMP to sleep
// after some tens of microseconds of waiting, if the user does not say how they wait (docs/evidence/performance.md). Sums of its threads would have other last bits, too. And where the processor lacks
// instructions for which the program was compiled, it ends with a sentence, not by the signal SIGILL at the first of them. Compiled with
// the same -march as the rest, in instructions that all have.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#if defined __GLIBC__
#include <malloc.h>
#endif

#if defined __x86_64__
#define PLAIN target("arch=x86-64")
#else
#define PLAIN
#endif

#define TURNS_OF_WAITING "10000"

// Libraries read the environment after this where they are a part of the program, and have done so before where they are shared ones
__attribute__((constructor(101), PLAIN)) static void hold_threads(void) {
    if (!getenv("OMP_WAIT_POLICY")) setenv("GOMP_SPINCOUNT", TURNS_OF_WAITING, 0);
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    void (*set_threads)(int) = (void (*)(int))dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
    if (set_threads) set_threads(1);
}

// Memory that is freed stays with the program, up to what the library keeps of itself after a while: else each array above 128 kB takes new
// pages of the system, which clears them, and meshes are built of many
#if defined __GLIBC__
__attribute__((constructor(102), PLAIN)) static void keep_memory(void) {
    const int array = 32 << 20, freed = 64 << 20; // [bytes]
    mallopt(M_MMAP_THRESHOLD, array);
    mallopt(M_TRIM_THRESHOLD, freed);
}
#endif

// Newer versions of OpenBLAS take their room as they are loaded, and where they cannot they try for ever: before a library begins, it is
// looked for here. `check_room` of src/setup/resource_estimate.f90 has the rest
#if defined __linux__
__attribute__((PLAIN)) static void check_room(void) {
    const int refused = 2;                       // `exit_input`
    const size_t room = 320000000;               // `of_algebra`
    static const char message[] = "hampm: the limit of the address space (ulimit -v) leaves no room for the library of linear algebra: allow "
                                  "about 600 MB and the memory of the model, or set no limit\n";
    void *taken = mmap(NULL, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (taken == MAP_FAILED) {
        ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
        (void)written;
        _exit(refused);
    }
    munmap(taken, room);
}

__attribute__((section(".preinit_array"), used)) static void (*const before_libraries)(void) = check_room;
#endif

#if defined __x86_64__
#include <stdio.h>

// Whether the compiler defines a macro as 1
#define DEFINED(macro) DEFINED_AS(macro)
#define DEFINED_AS(value) SECOND(COMMA_##value 1, 0)
#define COMMA_1 0,
#define SECOND(...) SECOND_OF(__VA_ARGS__, 0)
#define SECOND_OF(first, second, ...) second

#define NEED(macro, feature) \
    if (DEFINED(macro) && !__builtin_cpu_supports(feature)) lacking = feature

__attribute__((constructor, PLAIN)) static void check_processor(void) {
    const int exit_processor = 6;
    const char *lacking = NULL;
    __builtin_cpu_init();
    NEED(__GFNI__, "gfni");
    NEED(__AVX512VPOPCNTDQ__, "avx512vpopcntdq");
    NEED(__AVX512VNNI__, "avx512vnni");
    NEED(__AVX512VBMI__, "avx512vbmi");
    NEED(__AVX512VL__, "avx512vl");
    NEED(__AVX512DQ__, "avx512dq");
    NEED(__AVX512BW__, "avx512bw");
    NEED(__AVX512F__, "avx512f");
    NEED(__LZCNT__, "lzcnt");
    NEED(__MOVBE__, "movbe");
    NEED(__BMI2__, "bmi2");
    NEED(__FMA__, "fma");
    NEED(__AVX2__, "avx2");
    NEED(__AVX__, "avx");
    NEED(__SSE4_2__, "sse4.2");
    NEED(__POPCNT__, "popcnt");
    if (lacking) {
        fprintf(stderr, "hampm: this processor has no %s instructions, for which the program was built: build it with `make program "
                        "ARCH=x86-64`, or with ARCH=native on this machine\n", lacking);
        _exit(exit_processor);
    }
}
#endif
