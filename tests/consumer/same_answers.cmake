# Run by CTest: PROGRAM prints what PLAIN prints.
execute_process(COMMAND ${PLAIN} OUTPUT_VARIABLE expected COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE answers COMMAND_ERROR_IS_FATAL ANY)
if(NOT answers STREQUAL expected)
    message(FATAL_ERROR "${PROGRAM} prints\n${answers}where ${PLAIN} prints\n${expected}")
endif()
