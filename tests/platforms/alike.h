/* What both versions of the standard have alike but in their names: saved states and the end. For files that call their
 * table of functions `fmi` and what they run `instance`. */

static size_t width(size_t count) { return count; }

static void *save(void) {
    void *state = NULL;
    CALL(fmi.get_state(instance, &state));
    return state;
}

static void restore(void *state) { CALL(fmi.set_state(instance, state)); }

static void forget(void *state) { CALL(fmi.free_state(instance, &state)); }

static size_t serialized_size(void *state) {
    size_t size = 0;
    CALL(fmi.serialized_size(instance, state, &size));
    return size;
}

static void serialize(void *state, void *bytes, size_t size) { CALL(fmi.serialize(instance, state, bytes, size)); }

static void *deserialize(const void *bytes, size_t size) {
    void *state = NULL;
    CALL(fmi.deserialize(instance, bytes, size, &state));
    return state;
}

static void finish(void) {
    CALL(fmi.terminate(instance));
    fmi.free_instance(instance);
}
