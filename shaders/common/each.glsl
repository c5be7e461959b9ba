// One item after another, whatever the number of threads: EACH(i, count) is a loop's head.
layout(local_size_x = 64) in;
#define EACH(i, count) \
    int i = int(gl_GlobalInvocationID.x); i < (count); i += int(gl_NumWorkGroups.x * gl_WorkGroupSize.x)
