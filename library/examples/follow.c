/* Follows a recorded session: applies the recorded commands to another simulation, tick by tick, and compares
 * the states.
 *   follow SCENARIO RECORDING */
#include <stdio.h>

#include "unlatch.h"

static int give_up(const char* task) {
  const unlatch_error* error = unlatch_get_error(0);
  fprintf(stderr, "%s: %s\n", task, error != NULL ? error->text : "unknown error");
  return 1;
}

int main(int argc, char** argv) {
  unlatch_simulation *own = NULL, *recorded = NULL;
  unlatch_array channels = {.size = sizeof channels};
  uint64_t own_hash = 0, hash = 0;
  int64_t ticks = 0;
  unlatch_status status;

  if (argc != 3) {
    fprintf(stderr, "usage: follow SCENARIO RECORDING\n");
    return 2;
  }
  if (unlatch_load(argv[1], NULL, &own) < 0) return give_up("the scenario");
  if (unlatch_open_recording(argv[2], NULL, &recorded) < 0) return give_up("the recording");
  if (unlatch_get_array(recorded, UNLATCH_CHANNELS, 0, &channels) < 0) return give_up("channels");
  /* The replay's channels have the values of its latest step. */
  while ((status = unlatch_step(recorded)) == UNLATCH_OK) {
    if (unlatch_set_channels(own, 0, channels.rows, (const double*)channels.data) < 0) return give_up("commands");
    if (unlatch_step(own) < 0) return give_up("step");
    if (unlatch_get_hash(own, &own_hash) < 0 || unlatch_get_hash(recorded, &hash) < 0) return give_up("hash");
    ++ticks;
    if (own_hash != hash) {
      fprintf(stderr, "tick %lld differs\n", (long long)ticks);
      return 1;
    }
  }
  if (status != UNLATCH_END) return give_up("the recording");
  printf("%lld ticks, hash %016llx\n", (long long)ticks, (unsigned long long)own_hash);
  unlatch_close(recorded);
  unlatch_close(own);
  return 0;
}
