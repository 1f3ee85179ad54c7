/* How much memory an instance has. */
#ifndef HEAP_H
#define HEAP_H

#include "model.h"

/* Bytes of memory beyond what the module starts with: variables, models, saved states. Where memory is allocated, systems give
   what is used of it. A module for a loop alone has no use for more than its run takes. */
#ifndef PLANT_HEAP
#ifdef MODULE_HEAP
#define PLANT_HEAP MODULE_HEAP
#elif defined(PLANT_INSTANCES)
#define PLANT_HEAP (16u * PAGE)
#else
#define PLANT_HEAP (256u * PAGE)
#endif
#endif
#if PLANT_HEAP < 1 || PLANT_HEAP > 0x70000000
#error "PLANT_HEAP is a number of bytes: some hundred thousand, and less than 2 GB"
#endif
/* Whole pages, where the module takes pages into use. */
#ifdef MODULE_HEAP
#define MEMORY (MODULE_BYTES + (PLANT_HEAP + 15u) / 16u * 16u)
#else
#define MEMORY (MODULE_BYTES + (PLANT_HEAP + PAGE - 1u) / PAGE * PAGE)
#endif

#endif
