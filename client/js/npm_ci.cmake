# npm ci in FOLDER, from npm's cache if it has the packages.
execute_process(
  COMMAND ${NPM} ci --prefer-offline --ignore-scripts --no-audit --no-fund --loglevel=error
  WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  file(REMOVE_RECURSE ${FOLDER}/node_modules)
  message(FATAL_ERROR "npm could not fetch the packages of ${FOLDER}/package-lock.json. Give it a "
          "network once, or leave the web part out with -DHAPTIC_BUILD_WEB=OFF.")
endif()
file(TOUCH ${FOLDER}/node_modules/.package-lock.json)
