/* Recorded runs of the product make every choice of owner.pml, and each of their steps must be one
   of the model's that ends in the same state. A run stops at the first step that is not; the report
   names that of the first such run. */
c_decl {
\#include <stdio.h>
\#include <stdlib.h>
\#include "steps.h"
  static struct Step nothing, *steps = &nothing;
  static unsigned char *replayed;
  static long recorded;
  static void report(void) {
    long kinds[STEP_END] = {0}, all = 0, done = 0, first = -1;
    for (long i = 0; i < recorded; i++) {
      if (steps[i].event == STEP_RUN) continue;
      all++;
      done += replayed[i];
      kinds[steps[i].event] += replayed[i];
      if (!replayed[i] && first < 0) first = i;
    }
    printf("replayed %ld of %ld steps, by kind", done, all);
    for (int kind = STEP_RUN + 1; kind < STEP_END; kind++) printf(" %ld", kinds[kind]);
    if (first >= 0) printf("; not step %ld of kind %d", first, steps[first].event);
    printf("\n");
  }
  static void read_steps(void) {
    FILE *file = fopen(getenv("STEPS"), "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) exit(2);
    recorded = ftell(file) / (long)sizeof *steps;
    steps = calloc((size_t)recorded + 1, sizeof *steps);
    replayed = calloc((size_t)recorded + 1, 1);
    rewind(file);
    if (fread(steps, sizeof *steps, (size_t)recorded, file) != (size_t)recorded) exit(2);
    steps[recorded].event = STEP_END;
    atexit(report);
  }
}
int at; /* the next step */
byte told;

#define EVENT(kind) (c_expr { (steps[now.at].event == kind) })
#define MAY(choice) (c_expr { (steps[now.at].choice) })
#define TELL(answer) c_code { now.told |= answer; }
#define DONE                                                                          \
  c_expr { (steps[now.at].state == now.state && steps[now.at].gain == now.gain &&     \
            steps[now.at].lost == now.lost && steps[now.at].stop == now.stop &&       \
            steps[now.at].fault == now.fault && steps[now.at].holder == now.holder && \
            steps[now.at].detached == now.detached && steps[now.at].told == now.told) }; \
  c_code { replayed[now.at] = 1; };                                                   \
  at++;                                                                               \
  told = 0

active proctype replay() {
  c_code { read_steps(); };
  /* Any of the runs. */
  do
  :: c_expr { (steps[now.at].event != STEP_END) } ->
    c_code {
      do now.at++;
      while (steps[now.at].event != STEP_RUN && steps[now.at].event != STEP_END);
    }
  :: break
  od;
  at++
}
