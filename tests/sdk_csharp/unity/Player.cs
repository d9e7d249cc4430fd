// Plays the sample's scene as far as that goes without Unity: Start of each script, then frames with Update and coroutines.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading;
using OpenRoIS.Samples;
using OpenRoIS.Unity;
using Unity.WebRTC;
using UnityEngine;

public static class Player
{
    private static readonly BindingFlags Own = BindingFlags.Instance | BindingFlags.NonPublic;

    public static void Main(string[] arguments)
    {
        var frames = new Frames();
        SynchronizationContext.SetSynchronizationContext(frames);
        var scene = new GameObject();
        var client = scene.AddComponent<OpenRoISClient>();
        client.Address = arguments[0];
        var greeter = scene.AddComponent<Greeter>();
        greeter.Screen = scene.AddComponent<Renderer>();
        Call(client, "Start");
        Call(greeter, "Start");
        Until(frames, client, () => Field(greeter, "_body") != null);
        Console.WriteLine("reserved");
        greeter.Greet();
        Until(frames, client, () => !(bool)Field(greeter, "_isBusy"));
        Console.WriteLine("greeted");
        Until(frames, client, () => RTCPeerConnection.Said.Contains("local v=0 answer"));
        Console.WriteLine(RTCPeerConnection.Said[1]);
        // A scene ends at once, in any order.
        Call(client, "OnDestroy");
        Call(greeter, "OnDestroy");
        Console.WriteLine(RTCPeerConnection.Said.Last());
        Console.WriteLine(string.Join("; ", UnityEngine.Debug.Warnings));
        Misconfigured();
    }

    private static void Misconfigured()
    {
        var client = new GameObject().AddComponent<OpenRoISClient>();
        client.Address = "somewhere";
        try
        {
            Call(client, "Start");
        }
        catch (TargetInvocationException error)
        {
            Console.WriteLine(error.InnerException.Message);
        }
        Console.WriteLine(client.ConnectedAsync().Exception.InnerException.GetType().Name);
    }

    private static void Until(Frames frames, Component client, Func<bool> holds)
    {
        while (!holds())
        {
            Call(client, "Update");
            frames.Run();
            foreach (IEnumerator routine in MonoBehaviour.Coroutines.ToList())
            {
                if (!routine.MoveNext())
                {
                    MonoBehaviour.Coroutines.Remove(routine);
                }
            }
            Thread.Yield();
        }
    }

    private static void Call(Component component, string message)
    {
        component.GetType().GetMethod(message, Own).Invoke(component, new object[0]);
    }

    private static object Field(Component component, string name)
    {
        return component.GetType().GetField(name, Own).GetValue(component);
    }

    /// <summary>What Unity's own context does: awaits of scripts go on in the next frame.</summary>
    private sealed class Frames : SynchronizationContext
    {
        private readonly Queue<Action> _waiting = new Queue<Action>();

        public override void Post(SendOrPostCallback work, object state)
        {
            lock (_waiting)
            {
                _waiting.Enqueue(() => work(state));
            }
        }

        internal void Run()
        {
            List<Action> due;
            lock (_waiting)
            {
                due = _waiting.ToList();
                _waiting.Clear();
            }
            due.ForEach(each => each());
        }
    }
}
