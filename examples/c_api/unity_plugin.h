#ifndef HFH_UNITY_PLUGIN_H
#define HFH_UNITY_PLUGIN_H

#include <stdint.h>

#define HFH_UNITY_API __attribute__((visibility("default")))

/* A Unity terrain and the device's workspace on it, in Unity's axes: left-handed, y up, metres. */
typedef struct hfh_unity_terrain {
    const float* heights; /* TerrainData.GetHeights(0, 0, resolution, resolution), pinned: [z, x], 0 to 1 */
    int32_t resolution;   /* TerrainData.heightmapResolution */
    double extent[3];     /* TerrainData.size */
    double position[3];   /* Terrain.transform.position */
    double middle[3];     /* where the middle of the device's workspace is */
    double scale;         /* metres of terrain per metre of hand */
    double stiffness;     /* N/m at the hand */
} hfh_unity_terrain;

/* The driver, in Unity's axes; called by the plugin's thread alone. */
typedef struct hfh_unity_device {
    void* user;
    int32_t (*read)(void* user,
                    double* position); /* m from the middle of the workspace; 0: the device is lost */
    void (*send)(void* user, const double* newtons);
} hfh_unity_device;

/* Starts the plugin's thread; stops one that runs. 0, or an error of hfh_c.h. The heights have to stay until it is stopped. */
HFH_UNITY_API int32_t hfh_unity_start(const hfh_unity_terrain* terrain, const hfh_unity_device* device);
/* What was felt last: from the game's thread, once a frame. */
HFH_UNITY_API void hfh_unity_look(float* proxy, float* force, int32_t* touching);
/* Returns after the last update, with the force at zero. Unloading does the same. */
HFH_UNITY_API void hfh_unity_stop(void);
HFH_UNITY_API void UnityPluginUnload(void);

#endif
