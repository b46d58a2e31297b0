/* Replacement for the code that Simulink appends to an S-function: the host calls the functions above by their
 * names. */
