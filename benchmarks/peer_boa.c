/* Exact bi-objective search on an explicit graph: BOA* and NAMOA*dr, as their papers describe them, in plain C.
 *
 * BOA*      Hernandez Ulloa, Yeoh, Baier, Zhang, Suazo & Koenig, ICAPS 2020: labels in lexicographic order of (f1, f2),
 *           one number per node, the least g2 expanded so far, decides dominance in O(1).
 * NAMOA*dr  Pulido, Mandow & Perez de la Cruz 2015: the same dimensionality reduction for the closed labels, and eager
 *           dominance checks among the open labels of each node (here a list sorted by g1, with decreasing g2).
 *
 * Objective 1 is time, objective 2 energy. The heuristic is the ideal point: least time and least energy to go, found
 * backwards, for node numbers increase along every path. Labels whose least time passes the limit are not made.
 * Costs must be such that sums are exact (whole multiples of a power of two): then so are all comparisons.
 */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double g1, g2;
    int32_t node, parent;
} label_t; /* 24 bytes */

typedef struct {
    double f1, f2;
    int64_t label;
} entry_t; /* 24 bytes */

typedef struct {
    double g1, g2;
    int64_t label;
} open_t; /* an open label of a node, NAMOA*dr only */

typedef struct {
    open_t *at;
    int64_t first, count, room;
} list_t;

typedef struct {
    entry_t *heap;
    int64_t heap_count, heap_room, heap_most;
    label_t *pool;
    int64_t pool_count, pool_room;
    uint8_t *dead; /* NAMOA*dr only */
    int64_t dead_room;
    list_t *open;
    int64_t open_bytes;
    int failed;
} search_t;

static int before(const entry_t *a, const entry_t *b) {
    return a->f1 < b->f1 || (a->f1 == b->f1 && a->f2 < b->f2);
}

static void *grown(search_t *s, void *array, int64_t *room, size_t size) {
    *room *= 2;
    void *larger = realloc(array, (size_t)*room * size);
    if (!larger) s->failed = 1;
    return larger ? larger : array;
}

static void push(search_t *s, entry_t e) {
    if (s->heap_count == s->heap_room) s->heap = grown(s, s->heap, &s->heap_room, sizeof(entry_t));
    if (s->failed) return;
    int64_t i = s->heap_count++;
    if (s->heap_count > s->heap_most) s->heap_most = s->heap_count;
    while (i > 0) {
        int64_t up = (i - 1) >> 2;
        if (!before(&e, &s->heap[up])) break;
        s->heap[i] = s->heap[up];
        i = up;
    }
    s->heap[i] = e;
}

static entry_t pop(search_t *s) {
    entry_t top = s->heap[0], e = s->heap[--s->heap_count];
    int64_t i = 0, n = s->heap_count;
    for (;;) {
        int64_t child = 4 * i + 1, end = child + 4 < n ? child + 4 : n, best = child;
        if (child >= n) break;
        for (int64_t c = child + 1; c < end; c++)
            if (before(&s->heap[c], &s->heap[best])) best = c;
        if (!before(&s->heap[best], &e)) break;
        s->heap[i] = s->heap[best];
        i = best;
    }
    if (n > 0) s->heap[i] = e;
    return top;
}

static int64_t add_label(search_t *s, double g1, double g2, int32_t node, int64_t parent) {
    if (s->pool_count == s->pool_room) s->pool = grown(s, s->pool, &s->pool_room, sizeof(label_t));
    if (s->failed) return 0;
    if (s->open && s->pool_count >= s->dead_room) {
        int64_t old = s->dead_room;
        s->dead = grown(s, s->dead, &s->dead_room, 1);
        if (s->failed) return 0;
        memset(s->dead + old, 0, (size_t)(s->dead_room - old));
    }
    label_t *l = &s->pool[s->pool_count];
    l->g1 = g1;
    l->g2 = g2;
    l->node = node;
    l->parent = (int32_t)parent;
    return s->pool_count++;
}

/* NAMOA*dr: add to the open labels of a node unless one of them dominates it; drop those it dominates.
 * Returns the place where the label's number belongs, or NULL if dominated. */
static open_t *open_place(search_t *s, list_t *list, double g1, double g2) {
    int64_t low = list->first, high = list->first + list->count;
    while (low < high) { /* first entry with a later time */
        int64_t middle = (low + high) >> 1;
        if (list->at[middle].g1 <= g1)
            low = middle + 1;
        else
            high = middle;
    }
    if (low > list->first && list->at[low - 1].g2 <= g2) return NULL;
    int64_t from = low, to = low, end = list->first + list->count;
    while (from > list->first && list->at[from - 1].g1 == g1) from--; /* same time, more energy */
    while (to < end && list->at[to].g2 >= g2) to++;
    for (int64_t i = from; i < to; i++) s->dead[list->at[i].label] = 1;
    if (to > from) {
        memmove(&list->at[from + 1], &list->at[to], (size_t)(end - to) * sizeof(open_t));
        list->count -= to - from - 1;
    } else {
        if (end == list->room) {
            if (list->first > list->room / 2) { /* room at the front: labels leave there when they are expanded */
                memmove(list->at, &list->at[list->first], (size_t)list->count * sizeof(open_t));
                from -= list->first;
                end -= list->first;
                list->first = 0;
            } else {
                int64_t old = list->room;
                if (old == 0) list->room = 4;
                list->at = grown(s, list->at, &list->room, sizeof(open_t));
                if (s->failed) return NULL;
                s->open_bytes += (list->room - old) * (int64_t)sizeof(open_t);
            }
        }
        memmove(&list->at[from + 1], &list->at[from], (size_t)(end - from) * sizeof(open_t));
        list->count++;
    }
    list->at[from].g1 = g1;
    list->at[from].g2 = g2;
    return &list->at[from];
}

/* Search all Pareto-optimal paths from node 0 to the last node.
 *
 * eager        0: BOA*, 1: NAMOA*dr
 * front1/2     out, (front_room,) times and energies of the front, by time
 * counters     out, (4,) labels made, labels expanded, most open entries, bytes
 * returns the size of the front; -1 without memory, -2 when front_room is too small
 */
int64_t bi_objective_search(int64_t n_nodes, const int64_t *arc_ptr, const int32_t *arc_to, const double *cost1,
                            const double *cost2, double limit1, int eager, int64_t front_room, double *front1,
                            double *front2, int64_t *counters) {
    search_t s = {0};
    int32_t goal = (int32_t)(n_nodes - 1);
    double *h1 = malloc((size_t)n_nodes * sizeof(double)), *h2 = malloc((size_t)n_nodes * sizeof(double));
    double *least = malloc((size_t)n_nodes * sizeof(double));
    s.heap_room = s.pool_room = s.dead_room = 1 << 16;
    s.heap = malloc((size_t)s.heap_room * sizeof(entry_t));
    s.pool = malloc((size_t)s.pool_room * sizeof(label_t));
    if (eager) {
        s.open = calloc((size_t)n_nodes, sizeof(list_t));
        s.dead = calloc((size_t)s.dead_room, 1);
    }
    int64_t found = 0, expanded = 0;
    if (!h1 || !h2 || !least || !s.heap || !s.pool || (eager && (!s.open || !s.dead))) s.failed = 1;
    for (int64_t i = n_nodes - 1; i >= 0 && !s.failed; i--) {
        h1[i] = h2[i] = i == goal ? 0.0 : INFINITY;
        least[i] = INFINITY;
        for (int64_t a = arc_ptr[i]; a < arc_ptr[i + 1]; a++) {
            double t = cost1[a] + h1[arc_to[a]], e = cost2[a] + h2[arc_to[a]];
            if (t < h1[i]) h1[i] = t;
            if (e < h2[i]) h2[i] = e;
        }
    }
    if (!s.failed) {
        entry_t root = {h1[0], h2[0], add_label(&s, 0.0, 0.0, 0, -1)};
        push(&s, root);
    }
    while (s.heap_count > 0 && !s.failed) {
        entry_t e = pop(&s);
        label_t l = s.pool[e.label];
        if (eager) {
            if (s.dead[e.label]) continue;
            s.open[l.node].first++; /* of the open labels of one node, the quickest leaves first */
            s.open[l.node].count--;
        }
        if (l.g2 >= least[l.node] || e.f2 >= least[goal]) continue;
        least[l.node] = l.g2;
        expanded++;
        if (l.node == goal) {
            if (found == front_room) {
                found = -2;
                break;
            }
            front1[found] = l.g1;
            front2[found] = l.g2;
            found++;
            continue;
        }
        for (int64_t a = arc_ptr[l.node]; a < arc_ptr[l.node + 1]; a++) {
            int32_t to = arc_to[a];
            double g1 = l.g1 + cost1[a], g2 = l.g2 + cost2[a], f1 = g1 + h1[to], f2 = g2 + h2[to];
            if (g2 >= least[to] || f2 >= least[goal]) continue;
            if (f1 > limit1) continue;
            open_t *place = NULL;
            if (eager && !(place = open_place(&s, &s.open[to], g1, g2))) continue;
            int64_t label = add_label(&s, g1, g2, to, e.label);
            if (place) place->label = label;
            entry_t next = {f1, f2, label};
            push(&s, next);
        }
    }
    counters[0] = s.pool_count;
    counters[1] = expanded;
    counters[2] = s.heap_most;
    counters[3] = s.pool_count * (int64_t)sizeof(label_t) + s.heap_most * (int64_t)sizeof(entry_t) +
                  n_nodes * 3 * (int64_t)sizeof(double) + s.open_bytes + (eager ? s.pool_count : 0);
    if (eager && s.open)
        for (int64_t i = 0; i < n_nodes; i++) free(s.open[i].at);
    free(s.open);
    free(s.dead);
    free(s.heap);
    free(s.pool);
    free(h1);
    free(h2);
    free(least);
    return s.failed ? -1 : found;
}
