/*
 * A native plugin as Unity loads it: a thread of its own feels the terrain, and the game only looks at what it felt. Unity
 * is left-handed with y up, and TerrainData.GetHeights gives float[z, x] from 0 to 1.
 *
 * The device is what `hfh_unity_device` tells: two calls of its driver, in Unity's axes.
 */

#include "unity_plugin.h"

#include "hfh_c.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>
#include <time.h>

static struct {
    hfh_unity_device device;
    hfh_field* field;
    hfh_stylus* stylus;
    pthread_t thread;
    atomic_bool runs;
    bool is_started;
    pthread_mutex_t lock; /* of `shown`; the haptic thread only tries it and never waits */
    hfh_result shown;
} plugin = {.lock = PTHREAD_MUTEX_INITIALIZER};

static double seconds_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void* feel(void* unused) {
    const hfh_unity_device device = plugin.device;
    const double nothing[3] = {0, 0, 0};
    double before = seconds_now();
    (void)unused;
    while (atomic_load_explicit(&plugin.runs, memory_order_relaxed)) {
        double position[3], now;
        const struct timespec pause = {0, 500000}; /* a driver that waits for its device needs none */
        hfh_result result = {.size = sizeof result};
        if (!device.read(device.user, position)) break;
        now = seconds_now();
        hfh_stylus_update(plugin.stylus, position, NULL, now - before, &result);
        before = now;
        device.send(device.user, result.force);
        if (pthread_mutex_trylock(&plugin.lock) == 0) {
            plugin.shown = result;
            pthread_mutex_unlock(&plugin.lock);
        }
        nanosleep(&pause, NULL);
    }
    device.send(device.user, nothing);
    return NULL;
}

int32_t hfh_unity_start(const hfh_unity_terrain* terrain, const hfh_unity_device* device) {
    const double last = terrain->resolution - 1;
    const hfh_field_options ground = {.size = sizeof ground,
                                      .sample_type = HFH_FLOAT,
                                      .samples = terrain->heights,
                                      .columns = terrain->resolution,
                                      .rows = terrain->resolution,
                                      .origin = {terrain->position[0], terrain->position[2]},
                                      .spacing = {terrain->extent[0] / last, terrain->extent[2] / last},
                                      .height_scale = terrain->extent[1],
                                      .height_offset = terrain->position[1],
                                      .axes = HFH_Y_UP_LEFT};
    const hfh_material material = {.size = sizeof material, .stiffness = terrain->stiffness};
    hfh_stylus_options stylus = {.size = sizeof stylus, .material = &material, .scale = terrain->scale};
    int32_t error;
    hfh_unity_stop();
    if (hfh_abi() != HFH_C_ABI) return HFH_BAD_ARGUMENT;
    memcpy(stylus.offset, terrain->middle, sizeof stylus.offset);
    plugin.device = *device;
    error = hfh_field_create(&ground, &plugin.field);
    if (!error) error = hfh_stylus_create(plugin.field, &stylus, &plugin.stylus);
    if (!error) {
        plugin.shown = (hfh_result){.size = sizeof plugin.shown};
        atomic_store(&plugin.runs, true);
        plugin.is_started = pthread_create(&plugin.thread, NULL, feel, NULL) == 0;
        if (!plugin.is_started) error = HFH_OUT_OF_MEMORY;
    }
    if (error) hfh_unity_stop();
    return error;
}

void hfh_unity_look(float* proxy, float* force, int32_t* touching) {
    int k;
    pthread_mutex_lock(&plugin.lock);
    for (k = 0; k < 3; ++k) {
        proxy[k] = (float)plugin.shown.proxy[k];
        force[k] = (float)plugin.shown.force[k];
    }
    *touching = plugin.shown.touching;
    pthread_mutex_unlock(&plugin.lock);
}

void hfh_unity_stop(void) {
    if (plugin.is_started) {
        atomic_store(&plugin.runs, false);
        pthread_join(plugin.thread, NULL);
        plugin.is_started = false;
    }
    hfh_stylus_destroy(plugin.stylus);
    hfh_field_destroy(plugin.field);
    plugin.stylus = NULL;
    plugin.field = NULL;
}

/* Unity calls this before it unloads the plugin; a host that only closes the library comes through the destructor. */
void UnityPluginUnload(void) { hfh_unity_stop(); }
__attribute__((destructor)) static void unload(void) { hfh_unity_stop(); }
