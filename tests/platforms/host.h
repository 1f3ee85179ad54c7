/* What the host asks of a way to run the library, and what it offers to all of them. */

#ifndef HOST_H
#define HOST_H

#include <stddef.h>
#include <stdint.h>

/* A way to run the library, one instance at a time. Whatever the library refuses ends the program. */
struct face {
    const char *name;
    void (*load)(void);
    void (*instantiate)(const char *name, const char *token);
    void (*choose)(uint32_t reference, int item);
    void (*set)(const uint32_t *references, size_t count, const double *values);
    void (*initialize)(void);
    void (*step)(double time, double size);
    /* How many numbers `get` leaves for a number of variables. */
    size_t (*width)(size_t count);
    void (*get)(const uint32_t *references, size_t count, double *values);
    void *(*save)(void);
    void (*restore)(void *state);
    void (*forget)(void *state);
    size_t (*serialized_size)(void *state);
    void (*serialize)(void *state, void *bytes, size_t size);
    void *(*deserialize)(const void *bytes, size_t size);
    void (*finish)(void);
};

extern const struct face fmi2, fmi3, fmi3_events, fmi3_exchange;

/* Ends the program. */
void fail(const char *what);

/* A function of the library. */
void *function(const char *name);

/* Memory for one element more than asked for, so that there always is some. */
void *array(size_t count, size_t size);

/* Takes any call that a standard says succeeds with 0. */
#define CALL(call) do { if ((call) != 0) fail(#call); } while (0)

#endif
