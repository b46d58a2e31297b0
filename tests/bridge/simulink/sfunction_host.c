/* Runs bridge/stacks/unlatch_sfun.c like Simulink, as the pilot of bridge/examples/probe.yaml: throttle open at 0.1
 * s, shut at 0.3 s. The model's own part is a switch on the time. Exit code 1 with the block's error. */
#include <stdio.h>

#include "bridge/stacks/unlatch_sfun.c"

int mxGetString(const mxArray* from, char* to, size_t size) {
  if (from->text == NULL || strlen(from->text) >= size) return 1;
  memcpy(to, from->text, strlen(from->text) + 1);
  return 0;
}
double mxGetScalar(const mxArray* from) { return from->number; }
size_t mxGetNumberOfElements(const mxArray* from) { return from->count; }
const mxArray* mxGetCell(const mxArray* from, size_t index) { return &from->cells[index]; }

int main(int count, char** arguments) {
  const mxArray channels[] = {{count > 1 ? arguments[1] : "throttle", 0, NULL, 1}};
  const mxArray sensors[] = {{"gyro.x", 0, NULL, 1}, {"gyro.z", 0, NULL, 1}};
  const mxArray parameters[] = {{"pilot", 0, NULL, 1},  {"127.0.0.1", 0, NULL, 1}, {NULL, 7670, NULL, 1},
                                {NULL, 0, channels, 1}, {NULL, 0, sensors, 2},     {NULL, 0.001, NULL, 1}};
  static SimStruct S;
  S.parameters = parameters;
  S.parameter_count = (int)(sizeof parameters / sizeof parameters[0]);
  mdlInitializeSizes(&S);
  if (S.input_width != 1 || S.output_widths[0] != 2 || S.output_widths[1] != 1 || S.pointers != 1) return 2;
  mdlInitializeSampleTimes(&S);
  mdlStart(&S);
  while (S.error == NULL && !S.stop) {
    mdlOutputs(&S, 0);
    if (S.error != NULL) break;
    S.input[0] = S.outputs[1][0] > 0.0995 && S.outputs[1][0] < 0.2995 ? 1 : 0;
    mdlUpdate(&S, 0);
  }
  if (S.error != NULL) fprintf(stderr, "%s\n", S.error);
  printf("host: stopped at %.3f s\n", S.outputs[1][0]);
  mdlTerminate(&S);
  return S.error != NULL;
}
