/*
 * A stand-in for Unity: unity_host PLUGIN. Loads the plugin, gives it a terrain as float[z, x] and a device that presses on it,
 * looks at it once a frame, and unloads it without a word. Then no thread may go on, and the motors have a zero.
 */

#define _GNU_SOURCE
#include "unity_plugin.h"

#include <dirent.h>
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { resolution = 33 };

static int failures = 0;

#define CHECK(x)                                                                                             \
    do {                                                                                                     \
        if (!(x)) {                                                                                          \
            ++failures;                                                                                      \
            printf("line %d: %s\n", __LINE__, #x);                                                           \
        }                                                                                                    \
    } while (0)

/* The device: a hand that comes down and rests in the ground. */
static struct {
    atomic_int reads, sends;
    _Atomic double force[3];
    pthread_t game;
    atomic_bool is_games;
} device;

static int32_t read_device(void* user, double* position) {
    const int k = atomic_fetch_add(&device.reads, 1);
    (void)user;
    if (pthread_equal(pthread_self(), device.game)) atomic_store(&device.is_games, 1);
    position[0] = 0.001;
    position[1] = k < 1500 ? 0.01 - 0.015 * k / 1500 : -0.005;
    position[2] = 0.002;
    return 1;
}
static void send_device(void* user, const double* newtons) {
    int k;
    (void)user;
    for (k = 0; k < 3; ++k) atomic_store(&device.force[k], newtons[k]);
    atomic_fetch_add(&device.sends, 1);
}

static int threads(void) {
    int count = 0;
    DIR* tasks = opendir("/proc/self/task");
    const struct dirent* entry;
    while (tasks && (entry = readdir(tasks)) != NULL) count += entry->d_name[0] != '.';
    if (tasks) closedir(tasks);
    return count;
}

static void wait_ms(long ms) {
    const struct timespec pause = {ms / 1000, ms % 1000 * 1000000};
    nanosleep(&pause, NULL);
}

typedef int32_t (*start_call)(const hfh_unity_terrain*, const hfh_unity_device*);
typedef void (*look_call)(float*, float*, int32_t*);

/* POSIX lets a pointer from dlsym be a function's; ISO C has no cast for it. */
static void find(void* library, const char* name, void* call) {
    void* const found = dlsym(library, name);
    memcpy(call, &found, sizeof found);
}

int main(int argc, char** argv) {
    static float heights[resolution][resolution];
    const hfh_unity_terrain terrain = {.heights = &heights[0][0],
                                       .resolution = resolution,
                                       .extent = {64, 20, 64},
                                       .position = {100, -3, 200},
                                       .middle = {132, 7, 232},
                                       .scale = 200,
                                       .stiffness = 300};
    const hfh_unity_device driver = {NULL, read_device, send_device};
    const int before = threads();
    start_call start = NULL;
    look_call look = NULL;
    void (*stop)(void) = NULL;
    int x, z, frames, round;
    if (argc < 2) return 2;
    /* Rises to the east by 0.25, to the north by 0.125; the middle is 10 m above the lowest, which is at -3. */
    for (z = 0; z < resolution; ++z)
        for (x = 0; x < resolution; ++x)
            heights[z][x] = (float)(0.5 + (0.25 * 2 * (x - 16) + 0.125 * 2 * (z - 16)) / 20);

    for (round = 0; round < 2; ++round) {
        void* const plugin = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
        float proxy[3] = {0}, force[3] = {0};
        int32_t touching = 0;
        int sends;
        if (!plugin) {
            printf("%s\n", dlerror());
            return 1;
        }
        find(plugin, "hfh_unity_start", &start);
        find(plugin, "hfh_unity_look", &look);
        find(plugin, "hfh_unity_stop", &stop);
        if (!start || !look || !stop) return 1;
        memset(&device, 0, sizeof device);
        device.game = pthread_self();
        stop(); /* nothing runs */
        CHECK(start(&terrain, &driver) == 0);
        CHECK(threads() == before + 1);
        for (frames = 0; frames < 1500 && atomic_load(&device.reads) < 3000; ++frames) {
            look(proxy, force, &touching);
            wait_ms(16);
        }
        wait_ms(50);
        look(proxy, force, &touching);
        CHECK(touching == 1);
        CHECK(!atomic_load(&device.is_games));
        { /* 5 mm of hand below the middle, on a plane: up, west and south, by the plane's normal. */
            const double length = sqrt(1 + 0.25 * 0.25 + 0.125 * 0.125);
            const double ground = 7 + 0.25 * 0.2 + 0.125 * 0.4, depth = (ground - 6) / length;
            const double newtons = 300 * depth / 200;
            CHECK(fabs((double)force[0] + 0.25 * newtons / length) < 1e-3);
            CHECK(fabs((double)force[1] - newtons / length) < 1e-3);
            CHECK(fabs((double)force[2] + 0.125 * newtons / length) < 1e-3);
            CHECK(fabs((double)proxy[0] - (132.2 - 0.25 * depth / length)) < 1e-3);
            CHECK(fabs((double)proxy[1] - (6 + depth / length)) < 1e-3);
            CHECK(fabs((double)proxy[2] - (232.4 - 0.125 * depth / length)) < 1e-3);
        }
        CHECK(dlclose(plugin) == 0);
        CHECK(dlopen(argv[1], RTLD_NOW | RTLD_NOLOAD) == NULL);
        sends = atomic_load(&device.sends);
        CHECK(threads() == before);
        wait_ms(50);
        CHECK(atomic_load(&device.sends) == sends && sends > 2000);
        CHECK(device.force[0] == 0 && device.force[1] == 0 && device.force[2] == 0);
    }
    printf("%d failures\n", failures);
    return failures > 0;
}
