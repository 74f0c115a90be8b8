# The demo's tests. They link the demo's parts, and call the demo itself (HFH_TOUCH_TERRAIN).
hfh_use_png()
target_sources(hfh_tests PRIVATE
    apps/touch_terrain_gdal.test.cpp
    apps/touch_terrain_meaning.test.cpp
    apps/touch_terrain_outputs.test.cpp
    apps/touch_terrain_parts.test.cpp
    apps/touch_terrain_reads.test.cpp
    apps/touch_terrain_record.test.cpp
    apps/touch_terrain_refuses.test.cpp
    apps/touch_terrain_strokes.test.cpp)
target_link_libraries(hfh_tests PRIVATE touch_terrain_parts PNG::PNG)
